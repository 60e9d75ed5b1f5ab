using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace MotionSplice.Unity
{
    /// <summary>
    /// Poses the bones below this object, which have the names of the bank's joints, and moves the object by root motion.
    /// The model must be in its bind pose when the scene begins, and no Animator may move it.
    /// </summary>
    public sealed class MotionSpliceCharacter : MonoBehaviour
    {
        public MotionSpliceService service;
        public string locomotion = "walk";

        /// <summary>The character, for commands: null until the service has created it.</summary>
        public Character Character { get; private set; }

        readonly Pose pose = new Pose();
        readonly Dictionary<string, Bone> bind = new Dictionary<string, Bone>();
        Bone[] bones; // by joint; null for a joint without a bone
        Rig rig;
        Vector3 ground;
        float heading;

        sealed class Bone
        {
            public Transform Transform;
            public Quaternion Before, After;
        }

        void Awake()
        {
            // A joint's axes are those of the model in the bind pose. A bone has its own.
            Quaternion inwards = Quaternion.Inverse(transform.rotation);
            foreach (Transform bone in GetComponentsInChildren<Transform>())
            {
                if (bone == transform || bind.ContainsKey(bone.name)) continue;
                Quaternion before = Quaternion.Inverse(inwards * bone.parent.rotation);
                bind[bone.name] = new Bone { Transform = bone, Before = before, After = inwards * bone.rotation };
            }
        }

        async void Start()
        {
            try
            {
                Connection connection = await service.Connection;
                Character character = await connection.CreateAsync(locomotion, inPlace: true);
                if (this != null) Character = character;
                else await character.RemoveAsync(); // the object is destroyed already
            }
            catch (Exception problem) { Debug.LogError($"{name}: {problem.Message}"); }
        }

        void LateUpdate()
        {
            if (Character == null || !Character.TryGetPose(pose)) return;
            if (rig != pose.Rig) Bind(pose.Rig);
            if (bones == null) return;
            Move();
            for (int joint = 0; joint < bones.Length; joint++)
            {
                Bone bone = bones[joint];
                System.Numerics.Quaternion turn = pose.Rotations[joint];
                if (bone != null) bone.Transform.localRotation = bone.Before * new Quaternion(turn.X, turn.Y, turn.Z, turn.W) * bone.After;
            }
            bones[0].Transform.position = transform.TransformPoint(ToUnity(pose.Root));
        }

        void OnDestroy()
        {
            Character?.RemoveAsync();
        }

        /// <summary>Adds the root motion since the last picture to wherever the object is now.</summary>
        void Move()
        {
            Quaternion back = Quaternion.AngleAxis(-heading * Mathf.Rad2Deg, Vector3.up);
            transform.position += transform.rotation * (back * (ToUnity(pose.Ground) - ground));
            transform.rotation *= Quaternion.AngleAxis((pose.Heading - heading) * Mathf.Rad2Deg, Vector3.up);
            ground = ToUnity(pose.Ground);
            heading = pose.Heading;
        }

        void Bind(Rig newRig)
        {
            rig = newRig;
            bones = rig.Joints.Select(joint => bind.TryGetValue(joint, out Bone bone) ? bone : null).ToArray();
            var needed = new HashSet<int> { 0 }; // the root, and joints with a bone below
            for (int joint = bones.Length - 1; joint > 0; joint--)
                if (bones[joint] != null || needed.Contains(joint)) needed.Add(rig.Parents[joint]);
            string[] missing = needed.Where(joint => bones[joint] == null).Select(joint => rig.Joints[joint]).ToArray();
            if (missing.Length == 0) return;
            Debug.LogError($"{name}: no bones are named {string.Join(", ", missing)}. Build the bank on this character's skeleton.");
            bones = null;
        }

        static Vector3 ToUnity(System.Numerics.Vector3 place) => new Vector3(place.X, place.Y, place.Z);
    }
}
