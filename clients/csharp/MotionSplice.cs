// Client of a motionsplice service (protocol 3): characters over a WebSocket. One file, netstandard2.1, no dependencies.
//
//     var connection = await Connection.ConnectAsync("http://127.0.0.1:8000");
//     var hero = await connection.CreateAsync("walk");
//     await hero.ActAsync("wave", when: "left_foot");
//     // for each picture:
//     connection.Update();
//     if (hero.TryGetPose(pose)) { ... pose.Root, pose.Rotations ... }
//
// Messages are received on the thread pool. Update and TryGetPose belong to the thread that draws; Update raises all
// events there. Commands may be sent from any thread.
using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Net.WebSockets;
using System.Numerics;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace MotionSplice
{
    /// <summary>The service refused a command, the connection failed, or a message is malformed.</summary>
    public sealed class MotionSpliceException : Exception
    {
        /// <summary>The problem's type, such as "urn:motionsplice:unknown-clip"; empty if the service did not send one.</summary>
        public readonly string Type;

        public MotionSpliceException(string detail, string type = "", Exception cause = null) : base(detail, cause) { Type = type; }
    }

    /// <summary>How frames are sent. The protocol describes the values.</summary>
    public sealed class Settings
    {
        public string Axes = "gltf", Encoding = "float32", Token;
        public double Rate = 60;
        public int Ahead = 1;
        /// <summary>Whether frames also have the world positions of all joints (Frames.WorldPositions).</summary>
        public bool WorldPositions;

        internal Settings Copy() => (Settings)MemberwiseClone();
    }

    /// <summary>A locomotion: one clip, or a mix of up to four with their weights.</summary>
    public sealed class Mix
    {
        internal readonly object Value;

        public Mix(IReadOnlyDictionary<string, double> weights) { Value = weights.ToDictionary(one => one.Key, one => (object)one.Value); }
        Mix(string clip) { Value = clip; }
        public static implicit operator Mix(string clip) => new Mix(clip);
    }

    /// <summary>The joints of a bank, in the connection's axes and unit. Parents come before children.</summary>
    public sealed class Rig
    {
        public readonly string Bank, Axes;
        public readonly IReadOnlyList<string> Joints;
        /// <summary>Index of each joint's parent; -1 for the root.</summary>
        public readonly IReadOnlyList<int> Parents;
        /// <summary>Each joint's position in its parent's frame.</summary>
        public readonly IReadOnlyList<Vector3> Offsets;
        /// <summary>A joint's name, a list of names or null, by role.</summary>
        public readonly IReadOnlyDictionary<string, object> Roles;
        /// <summary>For each clip a map with "rate" and "duration".</summary>
        public readonly IReadOnlyDictionary<string, object> Clips;

        /// <summary>Reads the rig of an event "welcome" or "bank". Raises MotionSpliceException.</summary>
        public static Rig Parse(string json, string axes) => new Rig(new ServerEvent(Json.Parse(json)), axes);

        internal Rig(ServerEvent fields, string axes)
        {
            Axes = axes;
            Bank = fields.Text("bank");
            Joints = fields.List("joints").Cast<string>().ToArray();
            Parents = fields.List("parents").Select(parent => (int)(double)parent).ToArray();
            Offsets = fields.List("offsets").Cast<List<object>>()
                .Select(one => new Vector3((float)(double)one[0], (float)(double)one[1], (float)(double)one[2])).ToArray();
            Roles = fields.Map("roles");
            Clips = fields.Map("clips");
            if (Parents.Count != Joints.Count || Offsets.Count != Joints.Count || Parents.Where((one, joint) => one >= joint || one < -1).Any())
                throw new MotionSpliceException($"the rig of bank {Bank} is malformed");
        }
    }

    /// <summary>A message with frames. Its arrays are views of the message: nothing is copied.</summary>
    public sealed class Frames
    {
        public readonly string Bank = "";
        public readonly long Number = -1;
        public readonly int Count, Characters;
        public readonly double Rate, Time;
        public readonly Rig Rig;
        public readonly byte[] Message;
        readonly Blob ids, positions, steps, turns, rotations, worlds;
        readonly bool isShort;
        internal Dictionary<uint, int> Rows;
        internal int Session;

        /// <summary>Decodes a message. Raises MotionSpliceException if it is malformed, or is not of one of these rigs.</summary>
        public Frames(byte[] message, Func<string, Rig> rigs)
        {
            Message = message;
            var reader = new MessagePackReader(message);
            for (int left = reader.MapLength(); left > 0; left--)
            {
                string key = reader.Text();
                switch (key)
                {
                    case "bank": Bank = reader.Text(); break;
                    case "frame": Number = reader.Integer(); break;
                    case "count": Count = (int)Math.Min(reader.Integer(), int.MaxValue); break;
                    case "rate": Rate = reader.Number(); break;
                    case "time": Time = reader.Number(); break;
                    case "ids": ids = reader.Binary(); break;
                    case "root_positions": positions = reader.Binary(); break;
                    case "root_steps": steps = reader.Binary(); break;
                    case "root_turns": turns = reader.Binary(); break;
                    case "rotations": rotations = reader.Binary(); break;
                    case "world_positions": worlds = reader.Binary(); break;
                    default: reader.Skip(); break;
                }
            }
            Characters = ids.Length / sizeof(uint);
            Require(Number >= 0 && Rate > 0 && !double.IsNaN(Time) && !double.IsInfinity(Time), "no frame, rate or time");
            Require(Count > 0 && Count <= message.Length / 12, $"{Count} frames");
            Rig = rigs(Bank);
            Require(Rig != null, $"the bank {Bank}, whose rig is not known");
            long poses = (long)Count * Characters, joints = poses * Rig.Joints.Count;
            isShort = rotations.Length == 8 * joints;
            Check("ids", ids, 4 * Characters);
            Check("root_positions", positions, 12 * poses);
            Check("rotations", rotations, (isShort ? 8 : 16) * joints);
            Check("root_steps", steps, 12 * poses);
            Check("root_turns", turns, 4 * poses);
            if (worlds.Length > 0) Check("world_positions", worlds, 12 * joints);
        }

        public ReadOnlySpan<uint> Ids => View<uint>(ids);
        public ReadOnlySpan<Vector3> RootPositions(int frame) => View<Vector3>(positions).Slice(frame * Characters, Characters);
        public ReadOnlySpan<Vector3> RootSteps(int frame) => View<Vector3>(steps).Slice(frame * Characters, Characters);
        public ReadOnlySpan<float> RootTurns(int frame) => View<float>(turns).Slice(frame * Characters, Characters);

        /// <summary>The joints' world positions of one character; only with Settings.WorldPositions.</summary>
        public ReadOnlySpan<Vector3> WorldPositions(int frame, int row)
        {
            int joints = Rig.Joints.Count;
            return View<Vector3>(worlds).Slice((frame * Characters + row) * joints, joints);
        }

        /// <summary>Reads the rotations of one character, each joint's in its parent's frame.</summary>
        public void ReadRotations(int frame, int row, Span<Quaternion> into)
        {
            int joints = Rig.Joints.Count, first = (frame * Characters + row) * joints;
            if (!isShort)
            {
                View<Quaternion>(rotations).Slice(first, joints).CopyTo(into);
                return;
            }
            ReadOnlySpan<short> numbers = View<short>(rotations).Slice(4 * first, 4 * joints);
            for (int joint = 0; joint < joints; joint++)
            {
                short x = numbers[4 * joint], y = numbers[4 * joint + 1], z = numbers[4 * joint + 2], w = numbers[4 * joint + 3];
                into[joint] = Quaternion.Normalize(new Quaternion(Unit(x), Unit(y), Unit(z), Unit(w)));
            }
        }

        static float Unit(short number) => Math.Max(number / 32767f, -1f);

        ReadOnlySpan<T> View<T>(Blob blob) where T : struct =>
            MemoryMarshal.Cast<byte, T>(new ReadOnlySpan<byte>(Message, blob.Start, blob.Length));

        static void Check(string key, Blob blob, long length)
        {
            Require(blob.Length == length, $"{key} of {blob.Length} bytes, expected {length}");
            Require(blob.Start % 4 == 0, $"{key} at byte {blob.Start}, which is not a multiple of 4");
        }

        static void Require(bool holds, string found)
        {
            if (!holds) throw new MotionSpliceException($"malformed frames: found {found}. Are client and service of one version?");
        }
    }

    /// <summary>What to show of a character: filled by Character.TryGetPose. Keep one for each character.</summary>
    public sealed class Pose
    {
        public Rig Rig { get; private set; }
        /// <summary>The root joint's position.</summary>
        public Vector3 Root;
        /// <summary>Each joint's rotation in its parent's frame, the root's in the world.</summary>
        public Quaternion[] Rotations = Array.Empty<Quaternion>();
        /// <summary>The ground below the character, by its root motion; also of a character that stays in place.</summary>
        public Vector3 Ground;
        /// <summary>The heading in radians about the up axis, by its root motion.</summary>
        public float Heading;
        Quaternion[] worlds = Array.Empty<Quaternion>();

        /// <summary>Reads one frame of one character.</summary>
        public void Read(Frames frames, int frame, int row)
        {
            Resize(frames.Rig);
            Root = frames.RootPositions(frame)[row];
            frames.ReadRotations(frame, row, Rotations);
        }

        internal void BlendTo(Frames frames, int frame, int row, float share)
        {
            Root = Vector3.Lerp(Root, frames.RootPositions(frame)[row], share);
            frames.ReadRotations(frame, row, worlds);
            for (int joint = 0; joint < worlds.Length; joint++)
                Rotations[joint] = Quaternion.Lerp(Rotations[joint], worlds[joint], share); // by the shorter arc, and normalised
        }

        /// <summary>Writes the world position of each joint.</summary>
        public void WorldPositions(Span<Vector3> into)
        {
            for (int joint = 0; joint < Rotations.Length; joint++)
            {
                int parent = Rig.Parents[joint];
                into[joint] = parent < 0 ? Root : into[parent] + Vector3.Transform(Rig.Offsets[joint], worlds[parent]);
                worlds[joint] = parent < 0 ? Rotations[joint] : worlds[parent] * Rotations[joint];
            }
        }

        void Resize(Rig rig)
        {
            if (Rotations.Length != rig.Joints.Count)
            {
                Rotations = new Quaternion[rig.Joints.Count];
                worlds = new Quaternion[rig.Joints.Count];
            }
            Rig = rig;
        }
    }

    /// <summary>An event of the service: its name is in Name, the rest in Fields.</summary>
    public sealed class ServerEvent
    {
        public readonly string Name;
        public readonly IReadOnlyDictionary<string, object> Fields;

        internal ServerEvent(object document)
        {
            Fields = document as Dictionary<string, object> ?? throw new MotionSpliceException("malformed event: expected a map");
            Name = Fields.TryGetValue("event", out object name) ? name as string ?? "" : "";
        }

        public long Frame => (long)Get<double>("frame");
        /// <summary>The ids of the characters; empty if the event is about the connection.</summary>
        public uint[] Ids => Fields.ContainsKey("ids") ? List("ids").Select(id => (uint)(double)id).ToArray() : Array.Empty<uint>();
        public string Text(string key) => Get<string>(key);
        public List<object> List(string key) => Get<List<object>>(key);
        internal Dictionary<string, object> Map(string key) => Get<Dictionary<string, object>>(key);

        T Get<T>(string key) => Fields.TryGetValue(key, out object value) && value is T found ? found
            : throw new MotionSpliceException($"malformed event {Name}: {key} is missing or of another type");
    }

    /// <summary>A character of a connection. The protocol describes the commands; what is null is left to the service.</summary>
    public sealed class Character
    {
        public readonly uint Id;
        readonly Connection connection;
        Dictionary<string, object> created, act, wear;
        readonly List<long> jumps = new List<long>(); // frames in which it is put elsewhere
        internal Ground Placed;
        internal long PlacedFrame;

        internal Character(Connection connection, uint id, Dictionary<string, object> created)
        {
            this.connection = connection;
            this.created = created;
            Id = id;
        }

        /// <summary>Fills in what to show at the last Update. Returns false if no frame with the character is due yet.</summary>
        public bool TryGetPose(Pose pose) => connection.Read(this, pose);

        /// <summary>Fades to another locomotion, in step. Returns the first frame that shows it, as all commands do.</summary>
        public Task<long> PlayAsync(Mix locomotion, double? time = null, bool? loop = null, double? blend = null, string curve = null) =>
            Send(Fields("play", "locomotion", locomotion.Value, "time", time, "loop", loop, "blend", blend, "curve", curve), frame =>
            {
                created["locomotion"] = locomotion.Value;
                created["loop"] = loop ?? true;
                created.Remove("time");
            });

        /// <summary>Changes the weights of the mix.</summary>
        public Task<long> MixAsync(IReadOnlyDictionary<string, double> weights)
        {
            object value = new Mix(weights).Value;
            return Send(Fields("mix", "weights", value), frame => created["locomotion"] = value);
        }

        /// <summary>Begins an action. A playback of a part of it by its own clock is ownClock = [from, to].</summary>
        public Task<long> ActAsync(string action, string when = null, double? start = null, double? blend = null, double? blendOut = null,
            string curve = null, double? weight = null, bool? loop = null, object ownClock = null, string mask = null, string method = null,
            string posture = null)
        {
            var fields = Fields("act", "action", action, "when", when, "start", start, "blend", blend, "blend_out", blendOut, "curve", curve,
                "weight", weight, "loop", loop, "own_clock", ownClock, "mask", mask, "method", method, "posture", posture);
            return Send(fields, frame => act = loop == false ? null : fields); // what plays once does not begin again
        }

        /// <summary>Sets how much of the newest action is visible.</summary>
        public Task<long> WeightAsync(double weight) => Send(Fields("weight", "weight", weight), frame => { if (act != null) act["weight"] = weight; });

        /// <summary>Fades the action out.</summary>
        public Task<long> StopAsync(double? blend = null, string curve = null) =>
            Send(Fields("stop", "blend", blend, "curve", curve), frame => act = null);

        /// <summary>Sets the hands layer; null removes it.</summary>
        public Task<long> WearAsync(string hands, double? blend = null, string curve = null, double? weight = null)
        {
            var fields = Fields("wear", "blend", blend, "curve", curve, "weight", weight);
            fields["hands"] = hands;
            return Send(fields, frame => wear = hands == null ? null : fields);
        }

        /// <summary>Sets the playback speed, 0 to 8.</summary>
        public Task<long> SpeedAsync(double speed) => Send(Fields("speed", "speed", speed), frame => created["speed"] = speed);

        /// <summary>Moves the character at once.</summary>
        public Task<long> PlaceAsync(Vector3 position, double? heading = null) =>
            Send(Fields("place", "position", Json.Numbers(position), "heading", heading), frame => PutAt(new Ground(position, heading ?? 0), frame));

        /// <summary>Keeps the character at the origin, or releases it. Pose.Ground and Pose.Heading go on.</summary>
        public Task<long> InPlaceAsync(bool inPlace) => Send(Fields("in_place", "in_place", inPlace), frame =>
        {
            created["in_place"] = inPlace;
            jumps.Add(frame);
        });

        /// <summary>Holds standing feet in place, or no longer.</summary>
        public Task<long> LockFeetAsync(bool lockFeet) => Send(Fields("lock_feet", "lock_feet", lockFeet), frame => created["lock_feet"] = lockFeet);

        /// <summary>Sends the character to these receivers of the service's settings ("vmc", "livelink"), and to no others.</summary>
        public Task<long> SendToAsync(params string[] to) => Send(Fields("send", "to", to), frame => { });

        /// <summary>Removes the character.</summary>
        public Task<long> RemoveAsync() => Send(Fields("remove"), frame => connection.Forget(this));

        internal static Dictionary<string, object> Fields(string name, params object[] pairs)
        {
            var fields = new Dictionary<string, object> { ["do"] = name };
            for (int at = 0; at < pairs.Length; at += 2)
                if (pairs[at + 1] != null) fields[(string)pairs[at]] = pairs[at + 1];
            return fields;
        }

        internal void PutAt(Ground ground, long frame)
        {
            Placed = ground;
            PlacedFrame = frame;
            jumps.Add(frame);
        }

        internal void BeginAgain(long frame)
        {
            jumps.Clear();
            PutAt(Placed, frame);
        }

        internal bool JumpsBetween(long a, long b)
        {
            jumps.RemoveAll(frame => frame <= a);
            return jumps.Any(frame => frame <= b);
        }

        /// <summary>Returns the commands that make the character again on a new connection.</summary>
        internal List<object> Again()
        {
            var commands = new List<object>();
            foreach (var fields in new[] { created, wear, act })
            {
                if (fields == null) continue;
                var command = new Dictionary<string, object>(fields) { ["id"] = Id };
                foreach (string key in new[] { "ref", "time", "when", "start" }) command.Remove(key);
                commands.Add(command);
            }
            var create = (Dictionary<string, object>)commands[0];
            create["position"] = Json.Numbers(Placed.Position);
            create["heading"] = Placed.Heading;
            return commands;
        }

        Task<long> Send(Dictionary<string, object> fields, Action<long> done)
        {
            fields["id"] = Id;
            return connection.Send(new List<object> { fields }, done);
        }
    }

    /// <summary>A connection to a service, with its characters. It reconnects by itself, and makes them again where they were.</summary>
    public sealed class Connection : IDisposable
    {
        const double Patience = 10, Silence = 8, ShortestWait = 0.25, LongestWait = 5; // seconds
        const int MostArrivals = 1000; // that are kept if nobody calls Update
        readonly string address;
        readonly Settings settings;
        readonly object gate = new object();
        readonly CancellationTokenSource stop = new CancellationTokenSource();
        readonly SemaphoreSlim toSend = new SemaphoreSlim(0);
        readonly ConcurrentQueue<Arrival> inbox = new ConcurrentQueue<Arrival>();
        readonly Dictionary<string, Rig> rigs = new Dictionary<string, Rig>();
        readonly Dictionary<uint, Character> characters = new Dictionary<uint, Character>();
        readonly Playback playback = new Playback();
        List<Pending> pending = new List<Pending>(); // messages without a reply, in order
        int sent; // how many of them are sent on this connection
        string[] events;
        uint lastId;
        long lastRef;
        int session;

        /// <summary>The service has sent an event about characters or the bank.</summary>
        public event Action<ServerEvent> EventReceived;
        /// <summary>Frames have arrived, before they are due.</summary>
        public event Action<Frames> FramesReceived;
        /// <summary>The connection is lost, a message is malformed, or a character cannot be made again. The client goes on.</summary>
        public event Action<MotionSpliceException> Failed;
        /// <summary>There is a new connection, and all characters are being made again.</summary>
        public event Action Reconnected;

        /// <summary>The rig of the newest bank. A pose has the rig that belongs to it.</summary>
        public Rig Rig { get; private set; }
        public bool IsConnected { get; private set; }

        struct Arrival { public object What; public double At; }

        sealed class Pending
        {
            public long Ref;
            public string Text;
            public bool IsRestoration;
            public Action<long> Done;
            public TaskCompletionSource<long> Reply;
        }

        Connection(string url, Settings settings)
        {
            address = url.TrimEnd('/');
            if (address.StartsWith("http", StringComparison.Ordinal)) address = "ws" + address.Substring(4);
            this.settings = settings;
        }

        /// <summary>Connects to a service, such as "http://127.0.0.1:8000". Raises MotionSpliceException if the first try fails.</summary>
        public static Task<Connection> ConnectAsync(string url, Settings settings = null) => Task.Run(async () => // off the caller's context
        {
            var connection = new Connection(url, settings?.Copy() ?? new Settings());
            ClientWebSocket socket = await connection.Open();
            _ = connection.Run(socket);
            return connection;
        });

        /// <summary>Creates a character at a place on the ground. An id is chosen if it is null.</summary>
        public async Task<Character> CreateAsync(Mix locomotion, Vector3? position = null, double? heading = null, double? time = null,
            bool? loop = null, double? speed = null, bool? inPlace = null, uint? id = null)
        {
            var fields = Character.Fields("create", "locomotion", locomotion.Value, "heading", heading, "time", time, "loop", loop,
                "speed", speed, "in_place", inPlace, "position", position is Vector3 place ? Json.Numbers(place) : null);
            Character character;
            lock (gate)
            {
                while (id == null && characters.ContainsKey(++lastId)) { }
                character = new Character(this, id ?? lastId, fields);
            }
            fields["id"] = character.Id;
            await Send(new List<object> { fields }, frame =>
            {
                characters[character.Id] = character;
                character.PutAt(new Ground(position ?? Vector3.Zero, heading ?? 0), frame);
            });
            return character;
        }

        /// <summary>Changes the connection; null leaves a value as it is.</summary>
        public Task<long> SetAsync(double? rate = null, int? ahead = null, string[] events = null) =>
            Send(new List<object> { Character.Fields("set", "rate", rate, "ahead", ahead, "events", events) }, frame =>
            {
                settings.Rate = rate ?? settings.Rate;
                settings.Ahead = ahead ?? settings.Ahead;
                this.events = events ?? this.events;
            });

        /// <summary>Takes what has arrived, raises events, and sets the moment that poses show. Call it once for each picture.</summary>
        public void Update()
        {
            while (inbox.TryDequeue(out Arrival arrival))
            {
                if (arrival.What is Frames frames)
                {
                    lock (gate) playback.Take(frames, arrival.At, id => characters.TryGetValue(id, out Character found) ? found : null);
                    FramesReceived?.Invoke(frames);
                }
                else if (arrival.What is ServerEvent news) EventReceived?.Invoke(news);
                else if (arrival.What is MotionSpliceException problem) Failed?.Invoke(problem);
                else Reconnected?.Invoke();
            }
            playback.MoveTo(Now);
        }

        /// <summary>Ends the connection. Commands without a reply fail.</summary>
        public void Dispose()
        {
            stop.Cancel();
            lock (gate)
            {
                foreach (Pending one in pending) one.Reply.TrySetException(new ObjectDisposedException(nameof(Connection)));
                pending.Clear();
            }
        }

        static double Now => Stopwatch.GetTimestamp() / (double)Stopwatch.Frequency;

        internal bool Read(Character character, Pose pose)
        {
            lock (gate) return playback.Read(character, pose);
        }

        internal void Forget(Character character) => characters.Remove(character.Id);

        internal Task<long> Send(List<object> commands, Action<long> done)
        {
            lock (gate)
            {
                if (stop.IsCancellationRequested) return Task.FromException<long>(new ObjectDisposedException(nameof(Connection)));
                Pending message = Message(commands, done);
                pending.Add(message);
                toSend.Release();
                return message.Reply.Task;
            }
        }

        Pending Message(List<object> commands, Action<long> done)
        {
            ((Dictionary<string, object>)commands[0])["ref"] = ++lastRef;
            var reply = new TaskCompletionSource<long>(TaskCreationOptions.RunContinuationsAsynchronously);
            return new Pending { Ref = lastRef, Text = Json.Write(commands), Done = done, Reply = reply };
        }

        async Task<ClientWebSocket> Open()
        {
            var socket = new ClientWebSocket();
            if (settings.Token != null) socket.Options.SetRequestHeader("Authorization", "Bearer " + settings.Token);
            string parts = settings.WorldPositions ? "both" : "local", rate = settings.Rate.ToString(CultureInfo.InvariantCulture);
            string query = $"rate={rate}&ahead={settings.Ahead}&axes={settings.Axes}&encoding={settings.Encoding}&parts={parts}&deltas=true";
            using (var patience = CancellationTokenSource.CreateLinkedTokenSource(stop.Token))
            {
                patience.CancelAfter(TimeSpan.FromSeconds(Patience));
                try
                {
                    await socket.ConnectAsync(new Uri($"{address}/v1/characters?{query}"), patience.Token);
                    var message = await new MessageReader(socket).Read(patience.Token);
                    if (message.Text == null) throw new MotionSpliceException("the first message is not an event");
                    var welcome = new ServerEvent(Json.Parse(message.Text));
                    if (welcome.Name != "welcome") throw new MotionSpliceException(welcome.Text("detail"), welcome.Text("type"));
                    if (!Equals(welcome.Fields["protocol"], 3.0)) throw new MotionSpliceException($"expected protocol 3, found {welcome.Fields["protocol"]}");
                    var rig = new Rig(welcome, settings.Axes);
                    lock (gate) rigs[rig.Bank] = Rig = rig;
                    IsConnected = true;
                    return socket;
                }
                catch (Exception error)
                {
                    socket.Dispose();
                    throw error as MotionSpliceException ?? new MotionSpliceException($"cannot connect to {address}: {error.Message}. Does `motionsplice serve` run there?", "", error);
                }
            }
        }

        async Task Run(ClientWebSocket socket)
        {
            while (true)
            {
                string reason = await Serve(socket);
                IsConnected = false;
                socket.Dispose();
                if (stop.IsCancellationRequested) return;
                Put(new MotionSpliceException($"the connection is lost: {reason}"));
                for (double wait = ShortestWait; ; wait = Math.Min(2 * wait, LongestWait))
                {
                    try
                    {
                        await Task.Delay(TimeSpan.FromSeconds(wait), stop.Token);
                        socket = await Open();
                        break;
                    }
                    catch (OperationCanceledException) { return; }
                    catch (MotionSpliceException problem) { Put(problem); }
                }
                lock (gate) Restore();
                Put(null);
            }
        }

        /// <summary>Sends and receives until the connection ends. Returns why it did.</summary>
        async Task<string> Serve(ClientWebSocket socket)
        {
            using (var end = CancellationTokenSource.CreateLinkedTokenSource(stop.Token))
            {
                Task[] both = { Receive(socket, end), SendAll(socket, end.Token) };
                Task first = await Task.WhenAny(both);
                end.Cancel();
                try { await Task.WhenAll(both); } catch (Exception) { } // the first one tells why
                return first.Exception?.GetBaseException().Message ?? "no message for a while";
            }
        }

        async Task SendAll(ClientWebSocket socket, CancellationToken end)
        {
            while (true)
            {
                Pending next = null;
                lock (gate) if (sent < pending.Count) next = pending[sent++];
                if (next == null) await toSend.WaitAsync(end);
                else await socket.SendAsync(new ArraySegment<byte>(Encoding.UTF8.GetBytes(next.Text)), WebSocketMessageType.Text, true, end);
            }
        }

        async Task Receive(ClientWebSocket socket, CancellationTokenSource end)
        {
            var reader = new MessageReader(socket);
            while (true)
            {
                double silence = Math.Max(Silence, 2 * settings.Ahead / settings.Rate);
                lock (gate) end.CancelAfter(characters.Count > 0 ? TimeSpan.FromSeconds(silence) : Timeout.InfiniteTimeSpan);
                var message = await reader.Read(end.Token);
                double now = Now;
                try
                {
                    if (message.Text != null) Take(new ServerEvent(Json.Parse(message.Text)));
                    else Put(new Frames(message.Bytes, RigOf) { Session = session }, now);
                }
                catch (MotionSpliceException problem) { Put(problem); }
            }
        }

        void Take(ServerEvent news)
        {
            lock (gate)
            {
                if (news.Name == "bank")
                {
                    var rig = new Rig(news, settings.Axes);
                    rigs[rig.Bank] = Rig = rig;
                }
                if (news.Name == "done" || news.Name == "refused")
                {
                    if (sent == 0 || !Equals(news.Fields["ref"], (double)pending[0].Ref)) throw new MotionSpliceException("a reply without a command");
                    Pending replied = pending[0];
                    pending.RemoveAt(0);
                    sent--;
                    if (news.Name == "refused")
                    {
                        replied.Reply.SetException(new MotionSpliceException(news.Text("detail"), news.Text("type")));
                        return;
                    }
                    replied.Done(news.Frame);
                    replied.Reply.SetResult(news.Frame);
                    return;
                }
            }
            Put(news);
        }

        /// <summary>Puts the commands that make all characters again before those that have no reply yet.</summary>
        void Restore()
        {
            session++;
            var again = new List<Pending>();
            if (events != null) again.Add(Message(new List<object> { Character.Fields("set", "events", events) }, frame => { }));
            foreach (Character character in characters.Values)
            {
                character.Placed = playback.LastGround(character.Id) ?? character.Placed;
                again.Add(Message(character.Again(), character.BeginAgain));
                again[again.Count - 1].Reply.Task.ContinueWith(reply =>
                {
                    lock (gate) Forget(character);
                    string reason = reply.Exception.GetBaseException().Message;
                    Put(new MotionSpliceException($"character {character.Id} cannot be made again: {reason}"));
                }, TaskContinuationOptions.OnlyOnFaulted);
            }
            foreach (Pending one in again) one.IsRestoration = true;
            pending = again.Concat(pending.Where(one => !one.IsRestoration)).ToList();
            sent = 0;
        }

        Rig RigOf(string bank)
        {
            lock (gate) return rigs.TryGetValue(bank, out Rig rig) ? rig : null;
        }

        void Put(object what, double now = 0)
        {
            inbox.Enqueue(new Arrival { What = what, At = now });
            if (inbox.Count > MostArrivals) inbox.TryDequeue(out _);
        }
    }

    /// <summary>Reads whole messages of a socket.</summary>
    sealed class MessageReader
    {
        readonly ClientWebSocket socket;
        byte[] buffer = new byte[16384];

        public struct Message { public string Text; public byte[] Bytes; }

        public MessageReader(ClientWebSocket socket) { this.socket = socket; }

        public async Task<Message> Read(CancellationToken end)
        {
            for (int filled = 0; ;)
            {
                if (filled == buffer.Length) Array.Resize(ref buffer, 2 * filled);
                var part = await socket.ReceiveAsync(new ArraySegment<byte>(buffer, filled, buffer.Length - filled), end);
                if (part.MessageType == WebSocketMessageType.Close)
                    throw new MotionSpliceException($"closed with code {(int)part.CloseStatus.GetValueOrDefault()} {part.CloseStatusDescription}");
                filled += part.Count;
                if (!part.EndOfMessage) continue;
                if (part.MessageType == WebSocketMessageType.Text) return new Message { Text = Encoding.UTF8.GetString(buffer, 0, filled) };
                return new Message { Bytes = new ReadOnlySpan<byte>(buffer, 0, filled).ToArray() };
            }
        }
    }

    /// <summary>Place and heading on the ground, in the connection's axes, added up in 64 bits.</summary>
    struct Ground
    {
        double x, y, z;
        public double Heading;

        public Ground(Vector3 position, double heading) { x = position.X; y = position.Y; z = position.Z; Heading = heading; }

        public Vector3 Position => new Vector3((float)x, (float)y, (float)z);

        /// <summary>Returns the ground after a part of a step of root motion.</summary>
        public Ground Stepped(Vector3 step, float turn, float share, string axes)
        {
            double sin = Math.Sin(Heading), cos = Math.Cos(Heading);
            bool isZUp = axes == "unreal" || axes == "blender";
            var after = this;
            after.x += share * (isZUp ? cos * step.X - sin * step.Y : cos * step.X + sin * step.Z);
            after.y += share * (isZUp ? sin * step.X + cos * step.Y : step.Y);
            after.z += share * (isZUp ? step.Z : cos * step.Z - sin * step.X);
            after.Heading += share * turn;
            return after;
        }
    }

    /// <summary>Holds frames and decides what to show: the protocol's "Between frames". Times are in seconds.</summary>
    sealed class Playback
    {
        const double Remembered = 10, InTime = 0.99, Slew = 0.05, FirstDelay = 0.1, LongestGap = 0.25;
        readonly LinkedList<Held> held = new LinkedList<Held>(); // the first is shown
        readonly Queue<KeyValuePair<double, double>> samples = new Queue<KeyValuePair<double, double>>(); // when, and its value
        readonly List<double> sorted = new List<double>();
        Held past; // the frame before the first
        Held last; // the newest frame
        Held next; // what is shown is between the first and this one; null: the first
        float share;
        double offset, lateness, delay = FirstDelay, before = double.NaN;

        sealed class Held
        {
            public Frames Frames;
            public int Index;
            public double Due;
            public Ground[] Grounds;
            public long Number => Frames.Number + Index;
        }

        public void Take(Frames frames, double now, Func<uint, Character> characters)
        {
            if (last != null && last.Frames.Session != frames.Session)
            {
                held.Clear();
                samples.Clear();
                past = last = null;
            }
            if (last == null || frames.Number > last.Number) samples.Enqueue(new KeyValuePair<double, double>(now, now - frames.Time));
            while (held.Count > 0 && held.Last.Value.Number >= frames.Number) held.RemoveLast(); // a command has changed them
            frames.Rows = last != null && frames.Ids.SequenceEqual(last.Frames.Ids) ? last.Frames.Rows : RowsOf(frames);
            for (int index = 0; index < frames.Count; index++)
            {
                last = new Held { Frames = frames, Index = index, Due = frames.Time + index / frames.Rate };
                last.Grounds = Step(last, held.Last?.Value ?? past, characters);
                held.AddLast(last);
            }
        }

        public void MoveTo(double now)
        {
            if (held.Count == 0) return;
            Measure(now);
            if (double.IsNaN(before)) before = now;
            double most = Slew * (now - before), goal = 1 / last.Frames.Rate + lateness;
            delay += Math.Max(-most, Math.Min(most, goal - delay));
            before = now;
            double moment = now - offset - delay;
            while (held.Count > 1 && held.First.Next.Value.Due <= moment)
            {
                past = held.First.Value;
                held.RemoveFirst();
            }
            Held a = held.First.Value, b = held.First.Next?.Value;
            bool isCut = b == null || a.Frames.Rig != b.Frames.Rig || b.Number > a.Number + 1 && b.Due - a.Due > LongestGap;
            next = isCut ? null : b;
            share = isCut ? 0 : (float)Math.Max(0, Math.Min(1, (moment - a.Due) / (b.Due - a.Due)));
        }

        public bool Read(Character character, Pose pose)
        {
            if (held.Count == 0 || !held.First.Value.Frames.Rows.TryGetValue(character.Id, out int row)) return false;
            Held a = held.First.Value;
            pose.Read(a.Frames, a.Index, row);
            Ground ground = a.Grounds[row];
            bool isBetween = next != null && !character.JumpsBetween(a.Number, next.Number);
            if (isBetween && next.Frames.Rows.TryGetValue(character.Id, out int rowThere))
            {
                pose.BlendTo(next.Frames, next.Index, rowThere, share);
                ground = ground.Stepped(next.Frames.RootSteps(next.Index)[rowThere], next.Frames.RootTurns(next.Index)[rowThere], share, pose.Rig.Axes);
            }
            pose.Ground = ground.Position;
            pose.Heading = (float)ground.Heading;
            return true;
        }

        public Ground? LastGround(uint id) =>
            last != null && last.Frames.Rows.TryGetValue(id, out int row) ? last.Grounds[row] : (Ground?)null;

        void Measure(double now)
        {
            while (samples.Count > 1 && now - samples.Peek().Key > Remembered) samples.Dequeue();
            sorted.Clear();
            foreach (var sample in samples) sorted.Add(sample.Value);
            sorted.Sort();
            offset = sorted[0];
            lateness = sorted[(int)(InTime * (sorted.Count - 1))] - offset;
        }

        /// <summary>Returns where the characters are in a frame that follows another: root motion added up.</summary>
        Ground[] Step(Held held, Held former, Func<uint, Character> characters)
        {
            Frames frames = held.Frames;
            var grounds = new Ground[frames.Characters];
            for (int row = 0; row < grounds.Length; row++)
            {
                uint id = frames.Ids[row];
                Character character = characters(id);
                int rowBefore = 0;
                bool isKnown = former != null && former.Frames.Rows.TryGetValue(id, out rowBefore);
                bool isPlaced = character != null && character.PlacedFrame <= held.Number && (former == null || character.PlacedFrame > former.Number);
                if (isPlaced || !isKnown) grounds[row] = character?.Placed ?? default(Ground);
                else grounds[row] = former.Grounds[rowBefore].Stepped(frames.RootSteps(held.Index)[row], frames.RootTurns(held.Index)[row], 1, frames.Rig.Axes);
            }
            return grounds;
        }

        static Dictionary<uint, int> RowsOf(Frames frames)
        {
            var rows = new Dictionary<uint, int>();
            for (int row = 0; row < frames.Characters; row++) rows[frames.Ids[row]] = row;
            return rows;
        }
    }

    /// <summary>Where a blob is in a message.</summary>
    struct Blob { public int Start, Length; }

    /// <summary>Reads MessagePack in the forms that the protocol lists.</summary>
    struct MessagePackReader
    {
        readonly byte[] data;
        int at;

        public MessagePackReader(byte[] data) { this.data = data; at = 0; }

        public int MapLength()
        {
            byte head = Head();
            return (head & 0xF0) == 0x80 ? head & 0x0F : head == 0xDE ? (int)BigEndian(2) : throw Unexpected("a map");
        }

        public string Text()
        {
            byte head = Head();
            int length = (head & 0xE0) == 0xA0 ? head & 0x1F : head == 0xD9 ? (int)BigEndian(1) : head == 0xDA ? (int)BigEndian(2) : throw Unexpected("text");
            return Encoding.UTF8.GetString(data, Advance(length), length);
        }

        public Blob Binary()
        {
            if (Head() != 0xC6) throw Unexpected("bin 32");
            ulong length = BigEndian(4);
            if (length > (ulong)(data.Length - at)) throw Unexpected($"{length} bytes");
            return new Blob { Start = Advance((int)length), Length = (int)length };
        }

        public long Integer()
        {
            byte head = Head();
            ulong value = head < 0x80 ? head : head >= 0xCC && head <= 0xCF ? BigEndian(1 << (head - 0xCC)) : throw Unexpected("a whole number");
            return value <= long.MaxValue ? (long)value : throw Unexpected("a smaller number");
        }

        public double Number()
        {
            if (at >= data.Length || data[at] != 0xCB) return Integer();
            at++;
            return BitConverter.Int64BitsToDouble((long)BigEndian(8));
        }

        /// <summary>Skips a value of a key that this client does not know.</summary>
        public void Skip()
        {
            byte head = at < data.Length ? data[at] : (byte)0;
            if (head == 0xC6) Binary();
            else if ((head & 0xE0) == 0xA0 || head == 0xD9 || head == 0xDA) Text();
            else if (head == 0xC0 || head == 0xC2 || head == 0xC3) Head();
            else Number();
        }

        byte Head() => data[Advance(1)];

        ulong BigEndian(int bytes)
        {
            ulong value = 0;
            for (int start = Advance(bytes), index = 0; index < bytes; index++) value = value << 8 | data[start + index];
            return value;
        }

        int Advance(int length)
        {
            if (length > data.Length - at) throw Unexpected($"{length} more bytes");
            at += length;
            return at - length;
        }

        MotionSpliceException Unexpected(string expected) =>
            new MotionSpliceException($"malformed frames: expected {expected} before byte {at} of {data.Length}. Are client and service of one version?");
    }

    /// <summary>JSON: maps are Dictionary, lists are List, numbers are double.</summary>
    static class Json
    {
        const int Deepest = 32;

        public static List<object> Numbers(Vector3 place) => new List<object> { place.X, place.Y, place.Z };

        public static string Write(object value)
        {
            var text = new StringBuilder();
            Write(text, value);
            return text.ToString();
        }

        static void Write(StringBuilder text, object value)
        {
            string comma = "";
            if (value == null) text.Append("null");
            else if (value is string plain) WriteText(text, plain);
            else if (value is bool flag) text.Append(flag ? "true" : "false");
            else if (value is float single) text.Append(single.ToString("R", CultureInfo.InvariantCulture));
            else if (value is double number) text.Append(number.ToString("R", CultureInfo.InvariantCulture));
            else if (value is IDictionary<string, object> map)
            {
                text.Append('{');
                foreach (var one in map)
                {
                    text.Append(comma);
                    WriteText(text, one.Key);
                    text.Append(':');
                    Write(text, one.Value);
                    comma = ",";
                }
                text.Append('}');
            }
            else if (value is IEnumerable list)
            {
                text.Append('[');
                foreach (object one in list)
                {
                    text.Append(comma);
                    Write(text, one);
                    comma = ",";
                }
                text.Append(']');
            }
            else text.Append(Convert.ToString(value, CultureInfo.InvariantCulture));
        }

        static void WriteText(StringBuilder text, string plain)
        {
            text.Append('"');
            foreach (char one in plain)
            {
                if (one == '"' || one == '\\' || one < ' ') text.Append("\\u").Append(((int)one).ToString("x4"));
                else text.Append(one);
            }
            text.Append('"');
        }

        /// <summary>Parses a document. Raises MotionSpliceException.</summary>
        public static object Parse(string text)
        {
            int at = 0;
            object value = Value(text, ref at, 0);
            if (Peek(text, ref at) != '\0') throw Malformed(at);
            return value;
        }

        static object Value(string text, ref int at, int depth)
        {
            char first = Peek(text, ref at);
            if (depth > Deepest) throw Malformed(at);
            if (first == '"') return Text(text, ref at);
            if (first == '[')
            {
                var list = new List<object>();
                for (at++; !Ends(text, ref at, ']', list.Count);) list.Add(Value(text, ref at, depth + 1));
                return list;
            }
            if (first == '{')
            {
                var map = new Dictionary<string, object>();
                for (at++; !Ends(text, ref at, '}', map.Count);)
                {
                    if (Peek(text, ref at) != '"') throw Malformed(at);
                    string key = Text(text, ref at);
                    if (Peek(text, ref at) != ':') throw Malformed(at);
                    at++;
                    map[key] = Value(text, ref at, depth + 1);
                }
                return map;
            }
            int start = at;
            while (at < text.Length && (char.IsLetterOrDigit(text[at]) || text[at] == '-' || text[at] == '+' || text[at] == '.')) at++;
            string word = text.Substring(start, at - start);
            if (word == "null") return null;
            if (word == "true" || word == "false") return word == "true";
            return double.TryParse(word, NumberStyles.Float, CultureInfo.InvariantCulture, out double number) ? number : throw Malformed(start);
        }

        static bool Ends(string text, ref int at, char end, int before)
        {
            char next = Peek(text, ref at);
            if (next == end) at++;
            else if (before > 0 && next != ',') throw Malformed(at);
            else if (before > 0) at++;
            return next == end;
        }

        static string Text(string text, ref int at)
        {
            var plain = new StringBuilder();
            for (at++; at < text.Length && text[at] != '"'; at++)
            {
                if (text[at] != '\\')
                {
                    plain.Append(text[at]);
                    continue;
                }
                char escape = ++at < text.Length ? text[at] : '\0';
                int named = "bfnrt".IndexOf(escape);
                if (named >= 0) plain.Append("\b\f\n\r\t"[named]);
                else if (escape == '"' || escape == '\\' || escape == '/') plain.Append(escape);
                else if (escape == 'u' && at + 4 < text.Length && ushort.TryParse(text.Substring(at + 1, 4), NumberStyles.HexNumber, null, out ushort code))
                {
                    plain.Append((char)code);
                    at += 4;
                }
                else throw Malformed(at);
            }
            if (at++ >= text.Length) throw Malformed(at);
            return plain.ToString();
        }

        static char Peek(string text, ref int at)
        {
            while (at < text.Length && char.IsWhiteSpace(text[at])) at++;
            return at < text.Length ? text[at] : '\0';
        }

        static MotionSpliceException Malformed(int at) => new MotionSpliceException($"malformed event: unexpected text at character {at}");
    }
}
