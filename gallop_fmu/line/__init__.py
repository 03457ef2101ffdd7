"""From line data (code word, stringing tension, ice) to the values of a scene."""
