"""From the data of a line (code word, stringing tension, ice) to the numbers of a scene."""
