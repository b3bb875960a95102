"""How good it is: accuracy, repeatability, robustness, speed; the paper's tables beside ours."""
