"""The report of the figures: page, plots, pictures."""
