"""What is measured on: images, scenes, boards, views."""
