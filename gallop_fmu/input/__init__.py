"""Reading and writing of scenes."""
