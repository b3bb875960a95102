"""How figures are shown: numbers as text, neutral tables and their Markdown, plots, pictures."""
