"""Hold the bodies of the product, a JSON file each, as `python -m bench.presets` wrote them."""
