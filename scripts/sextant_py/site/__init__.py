"""The documentation as a site: generated pages, and links that leave docs/."""
