"""What is measured of it, one section a file."""
