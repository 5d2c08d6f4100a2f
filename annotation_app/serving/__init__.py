"""The Flask app and its server."""
