"""Builds the site: pages written, pages generated, Sphinx, and a look through the result."""
