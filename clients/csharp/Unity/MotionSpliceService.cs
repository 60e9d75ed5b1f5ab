using System;
using System.Threading.Tasks;
using UnityEngine;

namespace MotionSplice.Unity
{
    /// <summary>The connection that the characters of a scene share. Put it on one object of the scene.</summary>
    [DefaultExecutionOrder(-100)] // before the characters
    public sealed class MotionSpliceService : MonoBehaviour
    {
        public string url = "http://127.0.0.1:8000";
        public string token = "";
        public int rate = 60;

        /// <summary>The connection, once there is one. Its events are raised in Update.</summary>
        public Task<Connection> Connection { get; private set; }

        void Awake()
        {
            var settings = new Settings { Axes = "unity", Rate = rate, Token = token == "" ? null : token };
            Connection = MotionSplice.Connection.ConnectAsync(url, settings);
        }

        async void Start()
        {
            try { (await Connection).Failed += problem => Debug.LogWarning(problem.Message); }
            catch (Exception problem) { Debug.LogError(problem.Message); }
        }

        void Update()
        {
            if (Connection.Status == TaskStatus.RanToCompletion) Connection.Result.Update();
        }

        void OnDestroy()
        {
            Connection.ContinueWith(done => done.Result.Dispose(), TaskContinuationOptions.OnlyOnRanToCompletion);
        }
    }
}
