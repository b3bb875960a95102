"""What is measured: detectors, localisation, tracker; and how far figures can be trusted."""
