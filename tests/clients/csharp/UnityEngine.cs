// As much of UnityEngine as the Unity component uses, so that it is compiled and run without Unity.
using System;
using System.Collections.Generic;
using System.Linq;
using N = System.Numerics;

namespace UnityEngine
{
    public sealed class DefaultExecutionOrder : Attribute { public DefaultExecutionOrder(int order) { } }

    public struct Pose { } // the client has a class of this name

    public static class Mathf { public const float Rad2Deg = (float)(180 / Math.PI); }

    public static class Debug
    {
        public static readonly List<string> Errors = new List<string>();
        public static void LogError(object message) => Errors.Add((string)message);
        public static void LogWarning(object message) => Console.Error.WriteLine(message);
    }

    public struct Vector3
    {
        internal N.Vector3 Value;
        public Vector3(float x, float y, float z) { Value = new N.Vector3(x, y, z); }
        internal Vector3(N.Vector3 value) { Value = value; }
        public static Vector3 up => new Vector3(0, 1, 0);
        public static Vector3 operator +(Vector3 a, Vector3 b) => new Vector3(a.Value + b.Value);
        public static Vector3 operator -(Vector3 a, Vector3 b) => new Vector3(a.Value - b.Value);
    }

    public struct Quaternion
    {
        internal N.Quaternion Value;
        public Quaternion(float x, float y, float z, float w) { Value = new N.Quaternion(x, y, z, w); }
        internal Quaternion(N.Quaternion value) { Value = value; }
        public static Quaternion Inverse(Quaternion a) => new Quaternion(N.Quaternion.Conjugate(a.Value));
        public static Quaternion AngleAxis(float degrees, Vector3 axis) =>
            new Quaternion(N.Quaternion.CreateFromAxisAngle(axis.Value, degrees / Mathf.Rad2Deg));
        public static Quaternion operator *(Quaternion a, Quaternion b) => new Quaternion(N.Quaternion.Normalize(a.Value * b.Value));
        public static Vector3 operator *(Quaternion a, Vector3 b) => new Vector3(N.Vector3.Transform(b.Value, a.Value));
    }

    public class Transform
    {
        public string name;
        public Transform parent;
        internal readonly List<Transform> Children = new List<Transform>();
        public Vector3 localPosition;
        public Quaternion localRotation = new Quaternion(0, 0, 0, 1);
        public float Scale = 1;

        public Transform(string name, Transform parent)
        {
            this.name = name;
            this.parent = parent;
            parent?.Children.Add(this);
        }

        float WorldScale => Scale * (parent?.WorldScale ?? 1);

        public Quaternion rotation
        {
            get => parent == null ? localRotation : parent.rotation * localRotation;
            set => localRotation = parent == null ? value : Quaternion.Inverse(parent.rotation) * value;
        }

        public Vector3 position
        {
            get => parent == null ? localPosition : parent.TransformPoint(localPosition);
            set => localPosition = parent == null ? value
                : new Vector3((Quaternion.Inverse(parent.rotation) * (value - parent.position)).Value / parent.WorldScale);
        }

        public Vector3 TransformPoint(Vector3 point) => position + rotation * new Vector3(WorldScale * point.Value);

        internal IEnumerable<Transform> All() => new[] { this }.Concat(Children.SelectMany(child => child.All()));
    }

    public class MonoBehaviour
    {
        public Transform transform;
        public string name => transform.name;
        public T[] GetComponentsInChildren<T>() => transform.All().Cast<T>().ToArray();
    }
}
