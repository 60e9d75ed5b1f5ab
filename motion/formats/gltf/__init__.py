"""glTF 2.0 files (.glb, .gltf, .vrm, .vrma): container, accessors, tracks and scene."""
