"""List the bodies that come with the product, a JSON file each, and the script that wrote them."""
