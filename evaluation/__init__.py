"""How good it is: speed now, accuracy and repeatability to come beside it."""
