// The Unity component on a live service, with the tests' own UnityEngine.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading.Tasks;
using MotionSplice.Unity;
using UnityEngine;
using N = System.Numerics;

static class Scene
{
    /// <summary>Builds a model whose bones have axes of their own, plays it, and prints how far bones are from the joints.</summary>
    public static async Task Run(string url, string without)
    {
        var service = new MotionSpliceService { transform = new Transform("service", null), url = url };
        Call(service, "Awake", "Start");
        MotionSplice.Rig rig = (await service.Connection).Rig;
        var model = new Transform("hero", null) { localPosition = new Vector3(2, 0, -1), localRotation = Turn(0, 0.7f, 0) };
        var random = new Random(1);
        var armature = new Transform("Armature", model) { localRotation = Turn(-1.5f, 0, 0), Scale = 0.01f };
        var bones = new List<Transform>();
        for (int joint = 0; joint < rig.Joints.Count; joint++)
        {
            int parent = rig.Parents[joint];
            var bone = new Transform(rig.Joints[joint] == without ? "other" : rig.Joints[joint], parent < 0 ? armature : bones[parent]);
            bone.localRotation = Turn((float)random.NextDouble(), (float)random.NextDouble(), (float)random.NextDouble());
            N.Vector3 above = parent < 0 ? N.Vector3.Zero : bones[parent].position.Value;
            bone.position = new Vector3(above + (model.rotation * new Vector3(rig.Offsets[joint])).Value);
            bones.Add(bone);
        }
        var hero = new MotionSpliceCharacter { transform = model, service = service };
        Call(hero, "Awake", "Start");
        var pose = new MotionSplice.Pose();
        var places = new N.Vector3[bones.Count];
        double worst = 0;
        int pictures = 0;
        N.Vector3 start = model.position.Value;
        for (double end = Live.Seconds + 10; pictures < 300 && Debug.Errors.Count == 0 && Live.Seconds < end; await Task.Delay(5))
        {
            Call(service, "Update");
            Call(hero, "LateUpdate");
            if (hero.Character == null || !hero.Character.TryGetPose(pose)) continue;
            pose.WorldPositions(places);
            if (pictures++ == 0) start = model.position.Value;
            for (int joint = 0; joint < bones.Count; joint++)
                worst = Math.Max(worst, (bones[joint].position.Value - model.TransformPoint(new Vector3(places[joint])).Value).Length());
        }
        Program.Say("worst", worst, "pictures", pictures, "errors", Debug.Errors, "start", Program.Numbers(start), "end", Program.Numbers(model.position.Value),
            "ground", Program.Numbers(pose.Ground));
        Call(hero, "OnDestroy");
        Call(service, "OnDestroy");
    }

    static Quaternion Turn(float x, float y, float z) => new Quaternion(N.Quaternion.CreateFromYawPitchRoll(y, x, z));

    static void Call(MonoBehaviour component, params string[] names)
    {
        foreach (string name in names) component.GetType().GetMethod(name, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(component, null);
    }
}
