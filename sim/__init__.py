"""Runs the hardware against the golden model: engines behind one interface, a frame driver, a comparison."""
