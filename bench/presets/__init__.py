"""Write the bodies that come with the product: `python -m bench.presets`."""
