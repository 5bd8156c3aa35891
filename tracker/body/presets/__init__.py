"""The bodies that come with the product, one JSON file each, and the script that wrote them."""
