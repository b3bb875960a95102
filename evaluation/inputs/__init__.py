"""The inputs of measurements: images, scenes, boards, views."""
