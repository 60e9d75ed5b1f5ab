"""Files and folders on this machine or at a URL. Everything that reads clips or banks may import it."""
