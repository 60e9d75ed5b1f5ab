"""FBX files (.fbx): a child process that reads one with ufbx, and the scene made of what it returns."""
