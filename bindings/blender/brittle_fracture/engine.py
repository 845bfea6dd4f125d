"""The package brittle: bundled with the add-on, else the one that is installed."""
try:
    from .bundled import brittle
except ImportError:
    import brittle

__all__ = ["brittle"]
