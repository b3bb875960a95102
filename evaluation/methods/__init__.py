"""Methods: detectors, localisation, tracker, and intervals of figures."""
