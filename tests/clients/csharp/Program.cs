// The tests' program: "Program.exe MODE ...". the tests in Python say what each mode prints.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Numerics;
using MotionSplice;

static class Program
{
    static void Main(string[] arguments)
    {
        switch (arguments[0])
        {
            case "frames": PrintFrames(arguments[1]); break;
            case "playback": Play(arguments[1]); break;
            case "live": Live.Run(arguments[1]).Wait(); break;
            case "commands": Live.Commands(arguments[1]).Wait(); break;
            case "failures": Live.Failures(arguments[1]).Wait(); break;
            case "unity": Scene.Run(arguments[1], arguments[2]).Wait(); break;
            default: throw new ArgumentException(arguments[0]);
        }
    }

    public static void Say(params object[] pairs)
    {
        Console.WriteLine(Json.Write(Character.Fields("", pairs)));
        Console.Out.Flush();
    }

    public static IEnumerable<float> Numbers(Vector3 place) => new[] { place.X, place.Y, place.Z };

    /// <summary>Decodes each line of the standard input, a message in Base64, and prints what it is or which error it has.</summary>
    static void PrintFrames(string rigFile)
    {
        string text = File.ReadAllText(rigFile), line;
        var rig = Rig.Parse(text, new ServerEvent(Json.Parse(text)).Text("axes"));
        while ((line = Console.ReadLine()) != null)
        {
            try
            {
                var frames = new Frames(Convert.FromBase64String(line), bank => bank == rig.Bank ? rig : null);
                var pose = new Pose();
                var places = new List<float>();
                var turns = new List<float>();
                var placed = new Vector3[rig.Joints.Count];
                for (int frame = 0; frame < frames.Count; frame++)
                {
                    for (int row = 0; row < frames.Characters; row++)
                    {
                        pose.Read(frames, frame, row);
                        pose.WorldPositions(placed);
                        places.AddRange(placed.SelectMany(Numbers));
                        turns.AddRange(pose.Rotations.SelectMany(one => new[] { one.X, one.Y, one.Z, one.W }));
                    }
                }
                Say("frame", frames.Number, "count", frames.Count, "rate", frames.Rate, "time", frames.Time, "ids", frames.Ids.ToArray(),
                    "places", places, "rotations", turns,
                    "root_steps", Enumerable.Range(0, frames.Count).SelectMany(one => frames.RootSteps(one).ToArray()).SelectMany(Numbers),
                    "root_turns", Enumerable.Range(0, frames.Count).SelectMany(one => frames.RootTurns(one).ToArray()));
            }
            catch (MotionSpliceException problem) { Say("error", problem.Message); }
        }
    }

    /// <summary>Plays messages and pictures at the times of the standard input, and prints each picture.</summary>
    static void Play(string rigFile)
    {
        string rigText = File.ReadAllText(rigFile);
        var rigs = new Dictionary<string, Rig>();
        var playback = new Playback();
        var character = new Character(null, 7, Character.Fields("create"));
        var pose = new Pose();
        string line;
        while ((line = Console.ReadLine()) != null)
        {
            string[] words = line.Split(' ');
            double now = double.Parse(words[1], System.Globalization.CultureInfo.InvariantCulture);
            if (words[0] == "message")
            {
                var frames = new Frames(Convert.FromBase64String(words[2]), bank => rigs.TryGetValue(bank, out Rig known) ? known : rigs[bank] = Rig.Parse(rigText, "gltf"));
                playback.Take(frames, now, id => character);
            }
            else if (words[0] == "place") character.PutAt(new Ground(new Vector3(5, 0, 0), 1), long.Parse(words[2]));
            else
            {
                playback.MoveTo(now);
                bool isFound = playback.Read(character, pose);
                Say("found", isFound, "root", Numbers(pose.Root), "ground", Numbers(pose.Ground).Concat(new[] { pose.Heading }),
                    "rotations", pose.Rotations.SelectMany(one => new[] { one.X, one.Y, one.Z, one.W }));
            }
        }
    }
}
