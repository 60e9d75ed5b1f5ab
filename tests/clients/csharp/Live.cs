// The client on a live service.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Numerics;
using System.Threading.Tasks;
using MotionSplice;

/// <summary>One connection: compares joints with the service's world positions in every frame.</summary>
sealed class Live
{
    const int Enough = 350, Samples = 5; // frames in each of the three parts; messages of each part that are printed
    readonly string encoding;
    readonly int ahead;
    readonly Pose pose = new Pose(), shown = new Pose();
    readonly List<string> banks = new List<string>(), failures = new List<string>();
    readonly List<object> samples = new List<object>();
    Connection connection;
    Character hero;
    Vector3 root;
    double worst, jump = -1, held = -1;
    int frames, characters, reconnections;
    bool isExchanged;
    Task<long> late;

    Live(string encoding, int ahead) { this.encoding = encoding; this.ahead = ahead; }

    public static async Task Run(string url)
    {
        var players = (from encoding in new[] { "float32", "int16" } from ahead in new[] { 1, 8 } select new Live(encoding, ahead)).ToList();
        foreach (Live player in players) await player.Start(url);
        await Until(players, player => player.frames >= Enough);
        Program.Say("ready", true);
        await Until(players, player => player.isExchanged && player.frames >= 2 * Enough && player.banks.Count == 2);
        Program.Say("exchanged", true);
        await Until(players, player => player.reconnections == 1 && player.late.IsCompleted && player.frames >= 3 * Enough);
        Program.Say("results", players.Select(player => Character.Fields("", "encoding", player.encoding, "ahead", player.ahead,
            "worst", player.worst, "frames", player.frames, "banks", player.banks, "samples", player.samples, "jump", player.jump,
            "held", player.held, "failures", player.failures, "characters", player.characters, "late", player.late.Result)));
        foreach (Live player in players) player.connection.Dispose();
    }

    async Task Start(string url)
    {
        var settings = new Settings { Encoding = encoding, Ahead = ahead, Rate = 120, WorldPositions = true };
        connection = await Connection.ConnectAsync(url, settings);
        connection.FramesReceived += Check;
        connection.EventReceived += news => isExchanged |= news.Name == "bank";
        connection.Failed += problem =>
        {
            failures.Add(problem.Message);
            late = hero.SpeedAsync(0.9); // sent on the next connection
            hero.TryGetPose(shown);
            held = Vector3.Distance(shown.Root, root);
        };
        connection.Reconnected += () => { reconnections++; };
        var place = new Vector3(3, 0, 5); // near the origin: at 40 m the service's own float32 is 1.1e-5 m off
        hero = await connection.CreateAsync("walk", place, 2.5);
        var mix = new Mix(new Dictionary<string, double> { ["walk"] = 0.5, ["run"] = 0.5 });
        await connection.CreateAsync(mix, place, 2.5, speed: 0.4, id: 4000000000);
        Character third = await connection.CreateAsync("turn_180", place, 2.5, speed: 0.7);
        await Task.WhenAll(hero.ActAsync("carry_box", when: "left_foot"), third.ActAsync("wave", mask: "right_arm", blendOut: 0.2));
    }

    void Check(Frames received)
    {
        var places = new Vector3[received.Rig.Joints.Count];
        var all = new List<float>();
        for (int frame = 0; frame < received.Count; frame++)
        {
            for (int row = 0; row < received.Characters; row++)
            {
                pose.Read(received, frame, row);
                pose.WorldPositions(places);
                ReadOnlySpan<Vector3> theirs = received.WorldPositions(frame, row);
                for (int joint = 0; joint < places.Length; joint++)
                {
                    Vector3 off = Vector3.Abs(places[joint] - theirs[joint]);
                    worst = Math.Max(worst, Math.Max(off.X, Math.Max(off.Y, off.Z)));
                }
                all.AddRange(places.SelectMany(Program.Numbers));
            }
        }
        Vector3 now = received.RootPositions(0)[0];
        if (reconnections == 1 && jump < 0) jump = Vector3.Distance(root, now);
        root = received.RootPositions(received.Count - 1)[0];
        frames += received.Count;
        characters = received.Characters;
        if (banks.Count == 0 || banks[banks.Count - 1] != received.Bank) banks.Add(received.Bank);
        if (samples.Count < Samples * banks.Count)
            samples.Add(Character.Fields("", "message", Convert.ToBase64String(received.Message), "positions", all,
                "parents", received.Rig.Parents, "offsets", received.Rig.Offsets.SelectMany(Program.Numbers)));
    }

    static async Task Until(List<Live> players, Func<Live, bool> holds)
    {
        for (double end = Seconds + 120; !players.All(holds);)
        {
            if (Seconds > end) throw new TimeoutException();
            foreach (Live player in players) player.connection.Update();
            await Task.Delay(5);
        }
    }

    public static double Seconds => System.Diagnostics.Stopwatch.GetTimestamp() / (double)System.Diagnostics.Stopwatch.Frequency;

    /// <summary>Prints what fails on a service that misbehaves, until three things did.</summary>
    public static async Task Failures(string url)
    {
        using (Connection connection = await Connection.ConnectAsync(url))
        {
            var failures = new List<string>();
            connection.Failed += problem => failures.Add(problem.Message);
            await connection.CreateAsync("walk");
            for (double end = Seconds + 30; failures.Count < 3 && Seconds < end; await Task.Delay(5)) connection.Update();
            Program.Say("failures", failures);
        }
    }

    /// <summary>Sends every command, and some that are refused.</summary>
    public static async Task Commands(string url)
    {
        using (Connection connection = await Connection.ConnectAsync(url, new Settings { Axes = "unreal", Encoding = "int16", Ahead = 2 }))
        {
            var events = new List<string>();
            connection.EventReceived += news => events.Add(news.Name);
            await connection.SetAsync(rate: 30, ahead: 1, events: new[] { "action_began", "stride" });
            Character hero = await connection.CreateAsync("walk", new Vector3(100, 200, 0), 0.5, time: 0.25, loop: true, speed: 1.5, inPlace: false, id: 9);
            var mix = new Dictionary<string, double> { ["walk"] = 1, ["run"] = 2 };
            var frames = await Task.WhenAll(hero.PlayAsync(new Mix(mix), time: 0, loop: true, blend: 0.1, curve: "linear"), hero.MixAsync(mix),
                hero.ActAsync("wave", when: "now", start: 0.1, blend: 0.1, blendOut: 0.1, curve: "ease_in", weight: 0.5, loop: true,
                    ownClock: true, mask: "arms", method: "naive", posture: "off"),
                hero.ActAsync("wave", ownClock: new[] { 0.5, 1.5 }), hero.WeightAsync(0.25), hero.WearAsync(null, blend: 0.1, curve: "smooth"),
                hero.SpeedAsync(0.75), hero.InPlaceAsync(true), hero.LockFeetAsync(true), hero.SendToAsync(), hero.StopAsync(0.5, "ease_out"));
            await hero.PlaceAsync(new Vector3(50, 60, 0), -1);
            var refused = new List<string>();
            foreach (Func<Task> wrong in new Func<Task>[] { () => hero.PlayAsync("wlak"), () => hero.SpeedAsync(9), () => connection.CreateAsync("walk", id: 9),
                () => hero.SendToAsync("vmc"), () => hero.WearAsync("no \"hands\" \\ \u00e9") })
            {
                try { await wrong(); }
                catch (MotionSpliceException problem) { refused.Add(problem.Type + " " + problem.Message); }
            }
            var pose = new Pose();
            for (double end = Seconds + 5; Seconds < end && !(events.Contains("stride") && hero.TryGetPose(pose) && pose.Heading < -0.9); await Task.Delay(5)) connection.Update();
            long removed = await hero.RemoveAsync();
            Program.Say("frames", frames, "removed", removed, "refused", refused, "events", events, "ground", Program.Numbers(pose.Ground), "heading", pose.Heading);
        }
        foreach (string wrong in new[] { "http://127.0.0.1:1", url + "/nothing" })
        {
            try { await Connection.ConnectAsync(wrong); }
            catch (MotionSpliceException problem) { Program.Say("error", problem.Message); }
        }
    }
}
