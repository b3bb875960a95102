"""The page that compares figures of builds with the paper's."""
