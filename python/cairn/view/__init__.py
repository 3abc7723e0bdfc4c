"""Views of results: they read what a run left, and nothing calls them from mathematics."""
