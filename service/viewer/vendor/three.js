// The parts of three.js that the page uses, so that the bundle has no others.
export {
  BufferAttribute, BufferGeometry, Color, DataTexture, DirectionalLight, DoubleSide, FloatType, Group, HemisphereLight,
  InstancedBufferAttribute, InstancedMesh, Material, Matrix4, Mesh, MeshBasicMaterial, MeshDepthMaterial,
  MeshStandardMaterial, MOUSE, Object3D, OrthographicCamera, PCFShadowMap, PerspectiveCamera, PlaneGeometry, Quaternion,
  RGBAFormat, Scene, ShaderMaterial, ShadowMaterial, Skeleton, SkinnedMesh, Sphere, TOUCH, Vector2, Vector3, WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/addons/controls/OrbitControls.js';
