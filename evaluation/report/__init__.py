"""What becomes of the figures: page, plots, pictures."""
