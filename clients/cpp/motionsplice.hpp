// motionsplice.hpp: opens a bank of motionsplice and evaluates splices, without Python and without a network.
//
// C++17, no dependencies, for little-endian machines. Needs neither exceptions nor RTTI. Evaluating allocates nothing.
// Metres, seconds, radians; right-handed, Y up; quaternions are x, y, z, w. Licence: MIT, as motionsplice's.
//
//     motionsplice::Error error;
//     const motionsplice::Bank bank = motionsplice::Bank::open("bank", error);
//     if (error) return fail(error.message());
//     motionsplice::Evaluator evaluator(bank);
//     std::vector<float> rotations(4 * bank.joint_count()), root(3);
//     const motionsplice::Splice splice{bank.find("walk"), bank.find("wave")};
//     error = evaluator.pose(splice, 1.5, rotations.data(), root.data());
//
// The method and the format are described in docs/bank.md of the project.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "motionsplice.hpp reads banks on little-endian machines only"
#endif
#if defined(__GNUC__) || defined(__clang__)
#define MOTIONSPLICE_PREFETCH(address) __builtin_prefetch(address)
#else
#define MOTIONSPLICE_PREFETCH(address) static_cast<void>(address)
#endif

namespace motionsplice {

// ------------------------------------------------------------------------------------------------ what goes in and out

/// What went wrong, where, and what to do about it. Converts to true if there is an error.
struct Error {
    enum class Kind { none, bank, time_range, settings };

    Kind kind = Kind::none;
    std::string file;     ///< the file that is affected; may be empty
    std::string place;    ///< the character of a batch; may be empty
    std::string problem;  ///< one sentence without a full stop
    std::string mend;     ///< an imperative; may be empty

    explicit operator bool() const { return kind != Kind::none; }
    /// Returns "file, place: problem. mend", without the parts that are empty.
    std::string message() const;
};

enum class Method : std::uint8_t { none, naive, splice };
enum class Posture : std::uint8_t { off, relative, absolute, running };

constexpr int NOT_FOUND = -1;  ///< what `Bank::find` returns for an unknown name; refused by the evaluator
constexpr int NOTHING = -2;    ///< no action, or no hands

/// The upper body of one clip on the lower body of another. Clips and hands are numbers: see `Bank::find`.
struct Splice {
    int locomotion = 0;    ///< the clip that gives the root and the lower body
    int action = NOTHING;  ///< the clip that gives the upper body; NOTHING plays the locomotion alone
    int hands = NOTHING;   ///< hands to lay on the clip that gives the upper body: see `Bank::find_hands`
    double start = 0.0;    ///< seconds into the action, which begins at the first frame from here on that is in step
    Method method = Method::splice;
    Posture posture = Posture::relative;  ///< `running` needs a Memory
    std::int64_t cycles = 0;              ///< cycles that the locomotion has gone back: add those of each RootMotion
};

/// What the evaluator remembers of one character from frame to frame. Posture `running` needs it. With other postures
/// it is used only where a torso's joints lie on a line: the last clear alignment then goes on.
struct Memory {
    double share = 0.0;                     ///< weight of a new frame in the mean posture
    double turn[4] = {0.0, 0.0, 0.0, 1.0};  ///< the last clear alignment, xyzw
    double mean[6] = {};                    ///< mean positions of the left and of the right shoulder, metres
    bool begun = false;                     ///< whether the mean has begun

    /// Returns an empty memory of a character evaluated `rate` times per second of motion. The mean follows the splice
    /// within `time_constant` seconds.
    static Memory begin(double rate, double time_constant = 2.0);
};

/// One step along the root path of a clip, and the time after it.
struct RootMotion {
    double x = 0.0, y = 0.0, z = 0.0;  ///< metres to the left, up and ahead, in the heading before the step
    double turn = 0.0;                 ///< radians about Y
    double time = 0.0;                 ///< seconds into the clip after the step
    std::int64_t cycles = 0;           ///< cycles by which loops went back; add them to Splice::cycles
};

/// Where a character stands: position in metres and heading in radians about Y; 0 faces Z.
struct Place {
    double x = 0.0, y = 0.0, z = 0.0, heading = 0.0;

    void move(const RootMotion& motion);
};

/// The joints of a rig, parents before children, below joint 0.
struct Skeleton {
    std::vector<std::string> names;
    std::vector<std::int64_t> parents;               ///< -1 for joint 0
    std::vector<std::array<double, 3>> offsets;      ///< metres, in the parent's frame
    std::vector<std::int64_t> end_parents;           ///< the joint that carries each end site
    std::vector<std::array<double, 3>> end_offsets;  ///< metres, in that joint's frame
};

/// One clip of a bank; the fields are described in docs/bank.md.
struct ClipEntry {
    std::string name, kind, source;
    std::vector<std::string> tags, warnings, notes, uses;
    std::vector<std::string> stretches;  ///< the clips that an action which stands and walks by turns plays in order
    double enters = 0.0, leaves = 0.0;   ///< frames at which a stretch takes over and hands over
    int first_stretch = NOT_FOUND;       ///< number of the first of `stretches`; not in the manifest
    int next_stretch = NOT_FOUND;        ///< number of the stretch after this one; not in the manifest
    double rate = 0.0, first_phase = 0.0, last_phase = 0.0, cycles = 0.0;
    double mean_mismatch = 0.0, worst_mismatch = 0.0, shoulder_motion = 0.0, repetition = 0.0;
    std::int64_t first_row = 0, frame_count = 0, row_count = 0, first_cell = 0, cell_count = 0, loop = 0;
    std::int64_t stance = -1, parts = 15;  // of an action captured standing: see `stands`
    bool gait = false;
    bool mirrored = false;  ///< whether it is a mirror image, which has the rows of its clip; not in the manifest

    /// Whether it is an action captured standing, which is added to a locomotion at its own speed.
    bool stands() const { return stance >= 0; }
    /// Seconds from the first frame to the last, without the seam.
    double duration() const { return static_cast<double>(frame_count - 1) / rate; }
    /// The last frame that can be played: that of the seam if the clip loops.
    double last_frame() const { return static_cast<double>((loop > 0 ? row_count : frame_count) - 1); }
    /// Seconds that can be played; a clip that loops goes back when they have passed.
    double end() const { return last_frame() / rate; }
};

/// Hands that are aligned to a clip; the fields are described in docs/bank.md.
struct HandsEntry {
    std::string name, body, hand, source;
    std::vector<std::string> pairs, warnings;
    double rate = 0.0, mismatch = 0.0;
    std::int64_t first_row = 0;
    bool wrist = false;
};

namespace detail {

using Bytes = std::vector<unsigned char>;
struct Value;

struct Free {
    void operator()(void* memory) const { ::operator delete(memory, std::align_val_t(64)); }
};

/// Numbers that begin at a cache line.
template <class T>
struct Table {
    std::unique_ptr<T[], Free> numbers;
    std::size_t count = 0;

    const T* data() const { return numbers.get(); }
    const T& operator[](std::size_t at) const { return numbers[at]; }
};

/// The rotations in the rows of a table: planes of x, y, z and w, each of `width` lanes, from column `first_plane` on.
struct Half {
    std::vector<int> joints;
    std::int64_t first_plane = 0, width = 0, columns = 0;

    void lay_out(std::int64_t first_column, int first_joint);
};

/// How the sampled rotations of a half are mirrored: the lane of each one's twin, and the matrix that turns the twin's
/// rotation into its own.
struct Images {
    std::vector<int> twins;
    std::vector<std::array<float, 16>> matrices;
};

/// Two neighbouring rows of a table, and the share of the second one.
struct Between {
    std::int64_t row = 0;
    double share = 0.0;
};

}  // namespace detail

/// All clips of a game character on one skeleton. Immutable: evaluators of any number of threads may share it. An
/// evaluator holds its address, so neither move nor destroy it before them.
class Bank {
public:
    /// Fills in the bytes of a file, named relative to the bank's folder; returns false if it is missing.
    using Files = std::function<bool(const std::string& name, std::vector<unsigned char>& bytes)>;

    /// Reads and verifies the bank in a folder. If it is missing, damaged or of another version, fills in `error` and
    /// returns an empty bank.
    static Bank open(const std::string& folder, Error& error);
    /// The same from elsewhere, such as an engine's archive; `name` stands for the folder in errors.
    static Bank open(const Files& files, const std::string& name, Error& error);

    /// Returns the number of a clip: its index in `clips()`; NOT_FOUND if the name is unknown. `walk~mirror` names the
    /// mirror image of `walk`, whose number is larger by the size of `clips()`. If the rig has no mirror image, the
    /// number is refused by the evaluator.
    int find(std::string_view clip) const;
    /// Returns the entry of a clip or of its mirror image by its number, which must not be NOT_FOUND.
    const ClipEntry& clip(int number) const { return numbered_[std::size_t(number)]; }
    /// Returns the number of a hands clip: its index in `hand_clips()`; NOT_FOUND if the name is unknown.
    int find_hands(std::string_view name) const;

    int joint_count() const { return static_cast<int>(skeleton_.names.size()); }
    const Skeleton& skeleton() const { return skeleton_; }
    /// The joint by which the upper body hangs on the root.
    int pelvis() const { return static_cast<int>(pelvis_); }
    /// Whether clips have mirror images: not if left and right limbs hang on different joints.
    bool has_mirror_images() const { return !upper_images_.twins.empty(); }
    /// The clips, without their mirror images.
    const std::vector<ClipEntry>& clips() const { return clips_; }
    const std::vector<HandsEntry>& hands() const { return hands_; }
    /// Names of all hands clips, sorted.
    const std::vector<std::string>& hand_clips() const { return hand_clips_; }
    /// The BLAKE2b digest of the manifest's body, in hex. Equal digests mean equal banks.
    const std::string& digest() const { return digest_; }

private:
    friend class Evaluator;
    using Digests = std::array<std::string, 12>;
    using Turn = std::array<double, 4>;

    bool read(const Files& files, const std::string& name, Error& error);
    std::string read_body(const detail::Bytes& manifest, Digests& digests);
    std::string read_skeleton(const detail::Value& rig);
    std::string read_clips(const detail::Value& body);
    std::string read_roles(const detail::Value& map);
    std::string read_mirror(const detail::Value& map);
    bool mirror_half(const detail::Half& half, const std::vector<std::int64_t>& twins, const std::vector<Turn>& turns,
                     detail::Images& images) const;
    void find_parts(std::int64_t left_shoulder, std::int64_t right_shoulder, std::int64_t head);
    std::vector<std::int64_t> chain(std::int64_t joint) const;
    std::string clips_fault(const std::string& baseline);
    std::string link_stretches();
    std::string hands_fault();
    void lay_out(std::int64_t left_elbow, std::int64_t right_elbow);
    int find_own(std::string_view clip) const;
    int own(int clip) const { return clip - (this->clip(clip).mirrored ? static_cast<int>(clips_.size()) : 0); }
    std::string load(std::size_t table, const detail::Bytes& file);
    std::string contents_fault(std::size_t table) const;
    std::int64_t hand_row(int hands, int clip) const;
    detail::Between between(int clip, double frame, double last) const;
    double phase_at(int clip, detail::Between at) const;
    double guess(int clip, double phase) const;
    double frame_at(int clip, double phase, double near) const;
    double own_frame(int clip, double seconds) const;
    double frames_in_loop(int clip) const;
    double phase_of(int clip, double frame) const;
    double unrolled_phase(int clip, double seconds) const;
    double seconds_at(int clip, double phase) const;
    std::array<double, 6> posture(int clip) const;

    std::string digest_;
    Skeleton skeleton_;
    std::vector<ClipEntry> clips_, numbered_;  // the latter: clips, then mirror images
    std::vector<HandsEntry> hands_;
    std::vector<std::string> hand_clips_;
    std::vector<int> by_name_;                                   // clips, sorted by name
    std::vector<std::pair<std::pair<int, int>, int>> hands_of_;  // ((hands clip, clip), entry), sorted
    std::int64_t pelvis_ = 0, points_ = 0, cloud_width_ = 0;
    std::int64_t rows_ = 0, cells_ = 0, hand_rows_ = 0, stances_ = 0;
    bool has_stretches_ = false;
    std::vector<unsigned char> parts_of_lanes_;  // of `upper`: 0 trunk, 1 left arm, 2 right arm, 3 head
    detail::Half lower_half_, upper_half_, hands_half_;
    std::vector<int> lanes_of_hands_;             // in the upper half
    detail::Images lower_images_, upper_images_;  // empty if the rig has no mirror image
    std::array<std::array<double, 3>, 3> cloud_image_{};
    detail::Table<float> lower_, upper_, frame_of_phase_, feet_, stance_table_, hand_table_;
    detail::Table<double> phase_of_frame_, paths_, postures_, hand_frames_;
    detail::Table<std::uint8_t> contacts_;
    detail::Table<std::int32_t> neutral_;
};

/// Evaluates splices of a bank. It owns scratch memory, so make one for each thread.
class Evaluator {
public:
    explicit Evaluator(const Bank& bank);

    /// Writes one pose. See `poses`.
    Error pose(const Splice& splice, double time, float* rotations, float* root_position, Memory* memory = nullptr);

    /// Writes the poses of `count` characters. If a splice or a time is invalid, writes nothing and returns the error.
    /// @param splices         [count]
    /// @param times           [count] seconds into the locomotion, from 0 to `ClipEntry::end()`
    /// @param rotations       [count, J, 4] receives local rotations, xyzw
    /// @param root_positions  [count, 3] receives positions of joint 0 in the clip's own coordinates, metres
    /// @param memories        [count] or null; advanced by one frame
    Error poses(const Splice* splices, const double* times, int count, float* rotations, float* root_positions,
                Memory* memories = nullptr);

    /// Writes the world positions of all joints.
    /// @param rotations       [count, J, 4]
    /// @param root_positions  [count, 3] metres
    /// @param positions       [count, J, 3] receives metres
    void world_positions(const float* rotations, const float* root_positions, int count, float* positions);

    /// Returns the step along a clip's root path from `time` to `seconds` later, through its loops. A clip without a
    /// loop stops at its end. Returns no step for a clip that does not exist.
    RootMotion root_motion(int clip, double time, double seconds) const;

    /// Moves a pose of a locomotion at `time` from the clip's coordinates to a place in the world. The root keeps its
    /// offset from the clip's root path. Does nothing for a clip that does not exist.
    void put(const Place& place, int clip, double time, float* rotations, float* root_position) const;

private:
    static constexpr int BLOCK = 16;  // characters computed together

    struct Character;
    struct Torsos;

    bool exists(int clip) const;
    Error fault(const Splice& splice, double time, bool remembers) const;
    void evaluate(const Splice* splices, const double* times, int count, float* rotations, float* root_positions,
                  Memory* memories);
    void blend(const Splice& before, double time, double share, float* rotations, float* root_position,
               const Memory* memory);
    double find_stretch(const Splice& splice, double time, Splice& now, Splice& before) const;
    void look_up(const Splice* splices, const double* times, int count, Character* characters) const;
    void prefetch_upper(const Splice& splice, Character& character) const;
    void sample(const Character& character, float* rotations, float* root_position);
    void add(const Character& character);
    void correlate(const Character& character, int k, Torsos& torsos) const;
    void correlate_mirrored(const Character& character, int k, Torsos& torsos) const;
    std::array<double, 3> point(const float* rows, std::int64_t columns, double share, bool mirrored,
                                std::int64_t number) const;
    void turn_pelves(const Splice* splices, const Character* characters, int count, Torsos& torsos,
                     Memory* memories) const;
    void follow_posture(const Character& character, const double* stored, int k, const Torsos& torsos,
                        Memory& memory) const;
    std::array<double, 4> path(int clip, double frame) const;
    RootMotion walk(int clip, double from, double to) const;

    const Bank* bank_;
    // sampled rotations of one character: [4, width]; spare_lanes_ are a copy of those that are being mirrored
    std::vector<float> lower_lanes_, upper_lanes_, hand_lanes_, own_lanes_, stance_lanes_, spare_lanes_;
    std::vector<float> world_;  // [J, 7, LANES]
    std::vector<float> faded_;  // [J, 4], the pose of a stretch that is faded out
};

// ------------------------------------------------------------------------------------------------------------- details

namespace detail {

constexpr int LANES = 8;                     // planes are padded to this many floats
constexpr int LINE = 16;                     // floats in a cache line; rows are padded to it
constexpr std::int64_t ROOT = 0, CLOUD = 4;  // first columns of a row
constexpr std::size_t PELVIS = 0, POSTURE_FRAME = 1, TORSO_OFFSET = 2, FIRST_JOINT = 3;  // lanes of a row
constexpr double LATE = 1e-6;                              // seconds after a clip's end that count as its end
constexpr double IN_STEP = 1e-3;                           // cycles by which an action may begin before its start
constexpr double HANDOVER = 0.4;                           // seconds in which a stretch of a hybrid fades in
constexpr double EARLIER = 0.25;                           // cycles by which such a stretch may begin earlier
constexpr double LEAST_GAP = 1e-3;                         // of a clear rotation, see docs/bank.md
constexpr std::int64_t MOST_ROWS = std::int64_t(1) << 40;  // sums and products of counts stay far from overflow
constexpr std::size_t LARGEST_MANIFEST = std::size_t(64) << 20;  // bytes
constexpr int VERSION = 7;
constexpr std::string_view MIRRORED = "~mirror";  // ends the name of a mirror image
constexpr double HALF_A_CYCLE = 0.5;              // a mirror image is this much later in phase than its clip
constexpr const char* FORMAT = "motionsplice bank";
constexpr const char* REBUILD = "Build it again with `motionsplice precompute`";

/// The tables in the order of docs/bank.md.
enum TableNumber : std::size_t {
    LOWER, UPPER, PHASE_OF_FRAME, FRAME_OF_PHASE, PATHS, CONTACTS, FEET, POSTURES, NEUTRAL, STANCES, HANDS,
    HAND_FRAMES
};
constexpr std::array<const char*, 12> TABLES = {"lower", "upper", "phase_of_frame", "frame_of_phase", "paths",
                                                "contacts", "feet", "postures", "neutral", "stances", "hands",
                                                "hand_frames"};

inline std::int64_t whole(std::int64_t count, std::int64_t of) { return (count + of - 1) / of * of; }

/// The number of a part of the upper body by its name.
inline std::size_t part_named(std::string_view name) {
    constexpr std::array<std::string_view, 4> PARTS = {"trunk", "left arm", "right arm", "head"};
    return static_cast<std::size_t>(std::find(PARTS.begin(), PARTS.end(), name) - PARTS.begin());
}

inline std::string quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

inline void Half::lay_out(std::int64_t first_column, int first_joint) {
    first_plane = first_column;
    width = whole(first_joint + static_cast<std::int64_t>(joints.size()), LANES);
    columns = whole(first_plane + 4 * width, LINE);
}

// BLAKE2b, RFC 7693

class Blake2b {
public:
    static std::string digest(const unsigned char* data, std::size_t size) {
        std::uint64_t h[8];
        std::copy(START, START + 8, h);
        h[0] ^= 0x01010000u ^ DIGEST_BYTES;
        std::size_t done = 0;
        for (; size - done > 128; done += 128) compress(h, data + done, done + 128, false);
        unsigned char last[128] = {};
        if (size > done) std::memcpy(last, data + done, size - done);
        compress(h, last, size, true);
        std::string hex;
        for (std::size_t i = 0; i < DIGEST_BYTES; ++i) {
            const unsigned byte = static_cast<unsigned>(h[i / 8] >> (8 * (i % 8))) & 0xffu;
            hex += "0123456789abcdef"[byte >> 4];
            hex += "0123456789abcdef"[byte & 15u];
        }
        return hex;
    }

private:
    static constexpr std::size_t DIGEST_BYTES = 16;
    static constexpr std::uint64_t START[8] = {
        0x6a09e667f3bcc908u, 0xbb67ae8584caa73bu, 0x3c6ef372fe94f82bu, 0xa54ff53a5f1d36f1u,
        0x510e527fade682d1u, 0x9b05688c2b3e6c1fu, 0x1f83d9abfb41bd6bu, 0x5be0cd19137e2179u};
    static constexpr unsigned char ORDER[10][16] = {
        {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
        {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4}, {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
        {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13}, {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
        {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11}, {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
        {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5}, {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0}};

    static std::uint64_t right(std::uint64_t value, int bits) { return (value >> bits) | (value << (64 - bits)); }

    static void mix(std::uint64_t* v, int a, int b, int c, int d, std::uint64_t x, std::uint64_t y) {
        v[a] += v[b] + x;
        v[d] = right(v[d] ^ v[a], 32);
        v[c] += v[d];
        v[b] = right(v[b] ^ v[c], 24);
        v[a] += v[b] + y;
        v[d] = right(v[d] ^ v[a], 16);
        v[c] += v[d];
        v[b] = right(v[b] ^ v[c], 63);
    }

    static void compress(std::uint64_t* h, const unsigned char* block, std::uint64_t counted, bool last) {
        std::uint64_t m[16], v[16];
        std::memcpy(m, block, sizeof m);
        std::copy(h, h + 8, v);
        std::copy(START, START + 8, v + 8);
        v[12] ^= counted;
        v[14] = last ? ~v[14] : v[14];
        for (int round = 0; round < 12; ++round) {
            const unsigned char* s = ORDER[round % 10];
            for (int i = 0; i < 4; ++i) mix(v, i, 4 + i, 8 + i, 12 + i, m[s[2 * i]], m[s[2 * i + 1]]);
            for (int i = 0; i < 4; ++i) {
                mix(v, i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4, m[s[8 + 2 * i]], m[s[9 + 2 * i]]);
            }
        }
        for (int i = 0; i < 8; ++i) h[i] ^= v[i] ^ v[i + 8];
    }
};

// MessagePack

inline bool is_utf8(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
        const unsigned lead = static_cast<unsigned char>(text[at]);
        if ((lead >= 0x80 && lead < 0xc2) || lead > 0xf4) return false;
        const std::size_t more = lead < 0x80 ? 0 : lead < 0xe0 ? 1 : lead < 0xf0 ? 2 : 3;
        if (text.size() - at <= more) return false;
        unsigned code = more == 0 ? lead : lead & (0x3fu >> more);
        for (std::size_t i = 1; i <= more; ++i) {
            const unsigned next = static_cast<unsigned char>(text[at + i]);
            if ((next & 0xc0u) != 0x80u) return false;
            code = code << 6 | (next & 0x3fu);
        }
        const bool overlong = (more == 2 && code < 0x800) || (more == 3 && code < 0x10000);
        if (overlong || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return false;
        at += more + 1;
    }
    return true;
}

/// A value in MessagePack bytes: a view that copies nothing. `next` is where the value after it begins.
struct Value {
    enum class Type { invalid, nil, other, boolean, integer, real, text, binary, array, map };

    Type type = Type::invalid;
    std::uint64_t size = 0;           // bytes, items of an array, or pairs of a map
    std::int64_t integer = 0;         // also of a boolean
    double real = 0.0;
    const unsigned char* body = nullptr;
    const unsigned char* end = nullptr;

    /// Reads the head of the value at `at`; its type is invalid if the bytes end too early.
    static Value at(const unsigned char* at, const unsigned char* end) {
        Value value;
        value.end = end;
        if (at == end) return value;
        const unsigned lead = *at++;
        std::uint64_t number = 0;
        const auto take = [&](std::size_t bytes) {
            if (static_cast<std::size_t>(end - at) < bytes) return false;
            for (std::size_t i = 0; i < bytes; ++i) number = number << 8 | *at++;
            return true;
        };
        const auto sized = [&](Type kind, std::size_t bytes) {
            if (!take(bytes)) return;
            value.type = kind;
            value.size = number;
        };
        if (lead < 0x80 || lead >= 0xe0) {
            value.type = Type::integer;
            value.integer = static_cast<std::int8_t>(lead);
        } else if (lead < 0xc0) {
            value.type = lead < 0x90 ? Type::map : lead < 0xa0 ? Type::array : Type::text;
            value.size = lead & (lead < 0xa0 ? 15u : 31u);
        } else if (lead == 0xc0) {
            value.type = Type::nil;
        } else if (lead == 0xc2 || lead == 0xc3) {
            value.type = Type::boolean;
            value.integer = lead - 0xc2;
        } else if (lead >= 0xc4 && lead <= 0xc6) {
            sized(Type::binary, std::size_t(1) << (lead - 0xc4));
        } else if (lead >= 0xc7 && lead <= 0xc9) {
            sized(Type::other, std::size_t(1) << (lead - 0xc7));
            value.size += 1;  // the type of the extension
        } else if (lead == 0xca && take(4)) {
            const auto bits = static_cast<std::uint32_t>(number);
            float single = 0.0f;
            std::memcpy(&single, &bits, sizeof single);
            value.type = Type::real;
            value.real = single;
        } else if (lead == 0xcb && take(8)) {
            value.type = Type::real;
            std::memcpy(&value.real, &number, sizeof value.real);
        } else if (lead >= 0xcc && lead <= 0xd3 && take(std::size_t(1) << (lead & 3u))) {
            const unsigned unused = 64u - (8u << (lead & 3u));
            value.type = Type::integer;
            const auto high = static_cast<std::int64_t>(number << unused);
            value.integer = lead < 0xd0 ? static_cast<std::int64_t>(number) : high / (std::int64_t(1) << unused);
            if (lead == 0xcf && number >> 63) value.type = Type::other;  // larger than anything in a bank
        } else if (lead >= 0xd4 && lead <= 0xd8) {
            value.type = Type::other;
            value.size = 1 + (std::uint64_t(1) << (lead - 0xd4));
        } else if (lead >= 0xd9 && lead <= 0xdb) {
            sized(Type::text, std::size_t(1) << (lead - 0xd9));
        } else if (lead >= 0xdc) {
            sized(lead < 0xde ? Type::array : Type::map, lead & 1u ? 4 : 2);
        }
        value.body = at;
        if (!value.has_items() && value.size > static_cast<std::size_t>(end - at)) value.type = Type::invalid;
        if (value.type == Type::text && !is_utf8(value.text())) value.type = Type::invalid;
        return value;
    }

    bool has_items() const { return type == Type::array || type == Type::map; }
    std::string_view text() const { return {reinterpret_cast<const char*>(body), static_cast<std::size_t>(size)}; }

    /// Returns where the next value begins; null if this one is cut short.
    const unsigned char* next() const {
        const unsigned char* place = body;
        std::uint64_t left = has_items() ? size * (type == Type::map ? 2 : 1) : 0;
        if (type == Type::invalid) return nullptr;
        if (!has_items()) return body + size;
        for (; left > 0; --left) {
            const Value item = at(place, end);
            if (item.type == Type::invalid) return nullptr;
            place = item.has_items() ? item.body : item.body + item.size;
            left += item.has_items() ? item.size * (item.type == Type::map ? 2 : 1) : 0;
        }
        return place;
    }

    /// Calls `use(item)` for each item of an array until it returns false; returns whether all were used.
    template <class Use>
    bool each(const Use& use) const {
        if (type != Type::array) return false;
        const unsigned char* place = body;
        for (std::uint64_t i = 0; i < size; ++i) {
            const Value item = at(place, end);
            place = item.next();
            if (place == nullptr || !use(item)) return false;
        }
        return true;
    }

    /// Returns the value of a key of a map; invalid if it is missing.
    Value operator[](std::string_view key) const {
        const unsigned char* place = body;
        for (std::uint64_t i = 0; type == Type::map && i < size; ++i) {
            const Value name = at(place, end);
            place = name.next();
            if (place == nullptr) break;
            const Value found = at(place, end);
            if (name.type == Type::text && name.text() == key) return found;
            place = found.next();
            if (place == nullptr) break;
        }
        return Value();
    }
};

inline bool get(const Value& value, std::string& out) {
    if (value.type != Value::Type::text) return false;
    out = value.text();
    return true;
}

inline bool get(const Value& value, std::int64_t& out) {
    out = value.integer;
    return value.type == Value::Type::integer;
}

inline bool get(const Value& value, bool& out) {
    out = value.integer != 0;
    return value.type == Value::Type::boolean;
}

inline bool get(const Value& value, double& out) {
    out = value.real;
    return value.type == Value::Type::real && std::isfinite(value.real);
}

template <std::size_t N>
bool get(const Value& value, std::array<double, N>& out) {
    std::size_t at = 0;
    return value.size == N && value.each([&](const Value& item) { return get(item, out[at++]); });
}

/// Grows with the items that are really there, not by the count that the bytes claim.
template <class T>
bool get(const Value& value, std::vector<T>& out) {
    return value.each([&](const Value& item) {
        out.emplace_back();
        return get(item, out.back());
    });
}

/// Reads the fields of a map, one for each call; remembers the first that is missing or of the wrong type.
class Fields {
public:
    explicit Fields(const Value& map) : map_(map) {}

    template <class T>
    Fields& operator()(const char* name, T& out) {
        ++count_;
        if (fault_.empty() && !get(map_[name], out)) {
            fault_ = "the manifest has a missing or invalid field (" + quoted(name) + ")";
        }
        return *this;
    }

    /// Returns the fault; also if the map has other fields.
    std::string fault() const {
        if (fault_.empty() && map_.size != count_) return "the manifest has unknown fields";
        return fault_;
    }

private:
    Value map_;
    std::uint64_t count_ = 0;
    std::string fault_;
};

// Tables: .npy files as `numpy.save` writes them

template <class T>
constexpr const char* type_of();
template <>
constexpr const char* type_of<float>() { return "<f4"; }
template <>
constexpr const char* type_of<double>() { return "<f8"; }
template <>
constexpr const char* type_of<std::uint8_t>() { return "|u1"; }
template <>
constexpr const char* type_of<std::int32_t>() { return "<i4"; }

/// Copies the numbers of an .npy file. Returns a problem if it has another type or shape than expected.
template <class T>
std::string load(const Bytes& file, std::initializer_list<std::int64_t> shape, Table<T>& table) {
    constexpr std::size_t PREAMBLE = 10;
    std::string expected = std::string("{'descr': '") + type_of<T>() + "', 'fortran_order': False, 'shape': (";
    std::size_t row = sizeof(T);
    for (const std::int64_t* length = shape.begin(); length != shape.end(); ++length) {
        expected += std::to_string(*length) + (shape.size() == 1 ? "," : length + 1 == shape.end() ? "" : ", ");
        row *= length == shape.begin() ? 1u : static_cast<std::size_t>(*length);
    }
    expected += "), }";
    const bool named = file.size() >= PREAMBLE && std::memcmp(file.data(), "\x93NUMPY\x01\x00", 8) == 0;
    const std::size_t header = named ? file[8] + 256u * file[9] : 0;
    if (!named || file.size() - PREAMBLE < header) return "is cut short or not an array";
    const std::string_view found(reinterpret_cast<const char*>(file.data()) + PREAMBLE, header);
    const std::size_t length = std::min(found.find_last_not_of(" \n") + 1, found.size());
    if (found.substr(0, length) != expected) {
        std::string shown(found.substr(0, std::min<std::size_t>(length, 200)));
        std::replace_if(shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
        return "has the header " + shown + ", expected " + expected;
    }
    const std::size_t bytes = file.size() - PREAMBLE - header;
    const auto rows = static_cast<std::size_t>(*shape.begin());
    if (row == 0 ? bytes != 0 : bytes % row != 0 || bytes / row != rows) return "is cut short or not an array";
    table.numbers.reset(static_cast<T*>(::operator new(bytes, std::align_val_t(64), std::nothrow)));
    if (!table.numbers) return "does not fit into memory";
    if (bytes > 0) std::memcpy(table.numbers.get(), file.data() + PREAMBLE + header, bytes);
    table.count = bytes / sizeof(T);
    return "";
}

template <class T>
std::string finite_fault(const Table<T>& table) {
    for (std::size_t i = 0; i < table.count; ++i) {
        if (!std::isfinite(table[i])) return "holds numbers that are not finite";
    }
    return "";
}

inline void prefetch(const float* table, std::int64_t row, const Half& half) {
    const float* rows = table + row * half.columns;
    for (std::int64_t column = 0; column < 2 * half.columns; column += LINE) MOTIONSPLICE_PREFETCH(rows + column);
}

inline bool read_file(const std::string& path, Bytes& bytes) {
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), [](std::FILE* open) {
        return std::fclose(open);
    });
    if (!file) return false;
    bytes.clear();
    for (std::size_t got = 1; got > 0;) {  // until the end, for a folder too can be opened, and has a size
        const std::size_t before = bytes.size();
        bytes.resize(std::max<std::size_t>(2 * before, 1u << 16));
        got = std::fread(bytes.data() + before, 1, bytes.size() - before, file.get());
        bytes.resize(before + got);
    }
    return std::ferror(file.get()) == 0;
}

// Rotations

/// Quaternions, one of each character of a block.
template <int N>
struct Quaternions {
    double x[N], y[N], z[N], w[N];

    void set(int k, const double* q) { x[k] = q[0], y[k] = q[1], z[k] = q[2], w[k] = q[3]; }
    void get(int k, double* q) const { q[0] = x[k], q[1] = y[k], q[2] = z[k], q[3] = w[k]; }
};

/// Returns a b: turn by b, then by a.
template <int N>
Quaternions<N> product(const Quaternions<N>& a, const Quaternions<N>& b) {
    Quaternions<N> out;
    for (int k = 0; k < N; ++k) {
        out.x[k] = a.w[k] * b.x[k] + a.x[k] * b.w[k] + a.y[k] * b.z[k] - a.z[k] * b.y[k];
        out.y[k] = a.w[k] * b.y[k] - a.x[k] * b.z[k] + a.y[k] * b.w[k] + a.z[k] * b.x[k];
        out.z[k] = a.w[k] * b.z[k] + a.x[k] * b.y[k] - a.y[k] * b.x[k] + a.z[k] * b.w[k];
        out.w[k] = a.w[k] * b.w[k] - a.x[k] * b.x[k] - a.y[k] * b.y[k] - a.z[k] * b.z[k];
    }
    return out;
}

template <int N>
Quaternions<N> inverse(const Quaternions<N>& q) {
    Quaternions<N> out;
    for (int k = 0; k < N; ++k) out.x[k] = -q.x[k], out.y[k] = -q.y[k], out.z[k] = -q.z[k], out.w[k] = q.w[k];
    return out;
}

/// Returns a vector rotated by a quaternion.
inline std::array<double, 3> rotated(const double* q, const std::array<double, 3>& v) {
    const double x = 2.0 * (q[1] * v[2] - q[2] * v[1]), y = 2.0 * (q[2] * v[0] - q[0] * v[2]);
    const double z = 2.0 * (q[0] * v[1] - q[1] * v[0]);
    return {v[0] + q[3] * x + q[1] * z - q[2] * y, v[1] + q[3] * y + q[2] * x - q[0] * z,
            v[2] + q[3] * z + q[0] * y - q[1] * x};
}

/// sin(t angle) / sin(angle) as a polynomial in cos(angle) - 1 (Eberly 2011), for all lanes of a row at one t.
struct Weight {
    static constexpr int TERMS = 6;
    float t, factors[TERMS];

    explicit Weight(float share) : t(share) {
        for (int i = 1; i <= TERMS; ++i) {
            const float number = static_cast<float>(i);
            factors[i - 1] = (share * share / number - number) / (2.0f * number + 1.0f);
        }
    }

    float at(float below) const {  // the innermost term first
        float sum = 1.0f;
        for (int i = TERMS; i-- > 0;) sum = 1.0f + factors[i] * below * sum;
        return t * sum;
    }
};

/// Writes planes [4, width] of rotations: those at `a`, slerped to those at `b`. Keys lie in one hemisphere.
inline void slerp(const float* a, const float* b, std::int64_t width, float t, float* out) {
    const Weight to(t), back(1.0f - t);
    for (std::int64_t first = 0; first < width; first += LANES, a += LANES, b += LANES, out += LANES) {
        float q[4][LANES];
        for (int k = 0; k < LANES; ++k) {
            float below = -1.0f;
            for (std::int64_t c = 0; c < 4; ++c) below += a[c * width + k] * b[c * width + k];
            const float there = to.at(below), here = back.at(below);
            float size = 0.0f;
            for (std::int64_t c = 0; c < 4; ++c) {
                q[c][k] = here * a[c * width + k] + there * b[c * width + k];
                size += q[c][k] * q[c][k];
            }
            const float scale = 1.5f - 0.5f * size;  // nearly of unit length: one Newton step
            for (int c = 0; c < 4; ++c) q[c][k] *= scale;
        }
        for (int c = 0; c < 4; ++c) std::memcpy(out + c * width, q[c], sizeof q[c]);
    }
}

/// Mirrors planes [4, width] of rotations, from a copy of them in `spare`.
inline void mirror(const Images& images, const float* spare, float* lanes) {
    const std::size_t width = images.twins.size();
    for (std::size_t lane = 0; lane < width; ++lane) {
        const float* twin = spare + images.twins[lane];
        const float x = twin[0], y = twin[width], z = twin[2 * width], w = twin[3 * width];
        const float* m = images.matrices[lane].data();
        for (std::size_t c = 0; c < 4; ++c, m += 4) {
            lanes[c * width + lane] = (m[0] * x + m[1] * y) + (m[2] * z + m[3] * w);
        }
    }
}

/// Returns the matrix [4, 4] that takes the rotation q of a joint's twin to the joint's: `above^-1 f(q) turn`.
inline std::array<float, 16> image(const std::array<double, 4>& above, const std::array<double, 4>& turn) {
    const Quaternions<4> flip{{1.0, 0.0, 0.0, 0.0}, {0.0, -1.0, 0.0, 0.0}, {0.0, 0.0, -1.0, 0.0}, {0.0, 0.0, 0.0, 1.0}};
    Quaternions<4> parent, own;
    for (int k = 0; k < 4; ++k) parent.set(k, above.data()), own.set(k, turn.data());
    const Quaternions<4> columns = product(product(inverse(parent), flip), own);
    std::array<float, 16> matrix;
    for (std::size_t k = 0; k < 4; ++k) {
        double column[4];
        columns.get(static_cast<int>(k), column);
        for (std::size_t c = 0; c < 4; ++c) matrix[4 * c + k] = static_cast<float>(column[c]);
    }
    return matrix;
}

/// Correlations of pairs of clouds, one pair of each character of a block: m[i][j] = sum target_i source_j.
template <int N>
struct Correlations {
    double m[3][3][N] = {};
};

/// The rotations about the origin that best lay sources on targets, and whether they are clearly the best.
template <int N>
struct Alignments {
    Quaternions<N> turns;
    bool clear[N];
};

/// Horn 1987: a rotation is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix. Found by squaring the
/// shifted matrix sixteen times, that is, by 65,536 steps of the power method. No branches: lanes are characters.
template <int N>
Alignments<N> align(const Correlations<N>& correlations) {
    const auto& m = correlations.m;
    double n[10][N], s[10][N];  // 00 01 02 03 11 12 13 22 23 33
    for (int k = 0; k < N; ++k) {
        const double xx = m[0][0][k], xy = m[0][1][k], xz = m[0][2][k], yx = m[1][0][k], yy = m[1][1][k];
        const double yz = m[1][2][k], zx = m[2][0][k], zy = m[2][1][k], zz = m[2][2][k];
        n[0][k] = xx - yy - zz, n[1][k] = xy + yx, n[2][k] = zx + xz, n[3][k] = zy - yz, n[4][k] = yy - xx - zz;
        n[5][k] = yz + zy, n[6][k] = xz - zx, n[7][k] = zz - xx - yy, n[8][k] = yx - xy, n[9][k] = xx + yy + zz;
        const double squares = xx * xx + xy * xy + xz * xz + yx * yx + yy * yy + yz * yz + zx * zx + zy * zy + zz * zz;
        const double shift = std::sqrt(3.0 * squares);  // at least the largest absolute eigenvalue
        for (int i = 0; i < 10; ++i) s[i][k] = n[i][k];
        s[0][k] += shift, s[4][k] += shift, s[7][k] += shift, s[9][k] += shift;
    }
    for (int square = 0; square < 16; ++square) {
        if (square % 4 == 0) {  // often enough: a trace of 1 becomes 2e-10 at least by four squarings
            for (int k = 0; k < N; ++k) {
                const double trace = s[0][k] + s[4][k] + s[7][k] + s[9][k], scale = trace > 0.0 ? 1.0 / trace : 0.0;
                for (int i = 0; i < 10; ++i) s[i][k] *= scale;
            }
        }
        for (int k = 0; k < N; ++k) {
            const double a = s[0][k], b = s[1][k], c = s[2][k], d = s[3][k], e = s[4][k];
            const double f = s[5][k], g = s[6][k], h = s[7][k], i = s[8][k], j = s[9][k];
            s[0][k] = a * a + b * b + c * c + d * d, s[1][k] = a * b + b * e + c * f + d * g;
            s[2][k] = a * c + b * f + c * h + d * i, s[3][k] = a * d + b * g + c * i + d * j;
            s[4][k] = b * b + e * e + f * f + g * g, s[5][k] = b * c + e * f + f * h + g * i;
            s[6][k] = b * d + e * g + f * i + g * j, s[7][k] = c * c + f * f + h * h + i * i;
            s[8][k] = c * d + f * g + h * i + i * j, s[9][k] = d * d + g * g + i * i + j * j;
        }
    }
    Alignments<N> out;
    for (int k = 0; k < N; ++k) {  // every column is a multiple of the eigenvector: the one with the largest diagonal
        double x = s[0][k], y = s[1][k], z = s[2][k], w = s[3][k], most = s[0][k];
        const auto larger = [&](double diagonal, int i, int j, int l, int o) {
            const bool better = diagonal > most;
            x = better ? s[i][k] : x, y = better ? s[j][k] : y, z = better ? s[l][k] : z, w = better ? s[o][k] : w;
            most = better ? diagonal : most;
        };
        larger(s[4][k], 1, 4, 5, 6);
        larger(s[7][k], 2, 5, 7, 8);
        larger(s[9][k], 3, 6, 8, 9);
        const double size = x * x + y * y + z * z + w * w, scale = size > 0.0 ? 1.0 / std::sqrt(size) : 0.0;
        x *= scale, y *= scale, z *= scale, w *= scale;
        out.turns.x[k] = x, out.turns.y[k] = y, out.turns.z[k] = z, out.turns.w[k] = w;
        const double root = n[0][k] * x * x + n[4][k] * y * y + n[7][k] * z * z + n[9][k] * w * w +
                            2.0 * (x * (n[1][k] * y + n[2][k] * z + n[3][k] * w) + y * (n[5][k] * z + n[6][k] * w) +
                                   n[8][k] * z * w);
        double squares = 0.0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) squares += m[i][j][k] * m[i][j][k];
        }
        const double determinant = m[0][0][k] * (m[1][1][k] * m[2][2][k] - m[1][2][k] * m[2][1][k]) -
                                   m[0][1][k] * (m[1][0][k] * m[2][2][k] - m[1][2][k] * m[2][0][k]) +
                                   m[0][2][k] * (m[1][0][k] * m[2][1][k] - m[1][1][k] * m[2][0][k]);
        // the product of the root's distances to the others, by the slope of the characteristic polynomial
        const double cube = root * root * root, slope = cube - squares * root - 2.0 * determinant;
        out.clear[k] = cube > 0.0 && slope >= LEAST_GAP * cube;
    }
    return out;
}

}  // namespace detail

// ------------------------------------------------------------------------------------------------------------ the bank

inline std::string Error::message() const {
    const std::string where = file + (file.empty() || place.empty() ? "" : ", ") + place;
    return where + (where.empty() ? "" : ": ") + problem + "." + (mend.empty() ? "" : " " + mend + ".");
}

inline Memory Memory::begin(double rate, double time_constant) {
    Memory memory;
    memory.share = 1.0 - std::exp(-1.0 / (rate * time_constant));
    return memory;
}

inline Bank Bank::open(const std::string& folder, Error& error) {
    const auto files = [&](const std::string& name, detail::Bytes& bytes) {
        return detail::read_file(folder + "/" + name, bytes);
    };
    return open(files, folder, error);
}

inline Bank Bank::open(const Files& files, const std::string& name, Error& error) {
    Bank bank;
    error = Error();
    if (!bank.read(files, name, error)) return Bank();
    return bank;
}

inline bool Bank::read(const Files& files, const std::string& name, Error& error) {
    const std::string manifest = "manifest.msgpack";
    const auto fail = [&](const std::string& file, const std::string& problem, const char* mend = detail::REBUILD) {
        error = Error{Error::Kind::bank, file, "", problem, mend};
        return false;
    };
    detail::Bytes bytes;
    if (!files(manifest, bytes)) {
        return fail(name, "this folder is not a bank", "Build one with `motionsplice precompute CLIPS... --out BANK`");
    }
    Digests digests;
    if (const std::string problem = read_body(bytes, digests); !problem.empty()) {
        return fail(name + "/" + manifest, problem);
    }
    for (std::size_t table = 0; table < detail::TABLES.size(); ++table) {
        const std::string title = "table " + detail::quoted(detail::TABLES[table]) + " ";
        const std::string file = "tables/" + digests[table] + ".npy", path = name + "/" + file;
        bytes.clear();
        if (!files(file, bytes)) return fail(path, title + "is missing");
#ifndef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION  // a fuzzer cannot guess digests
        if (detail::Blake2b::digest(bytes.data(), bytes.size()) != digests[table]) {
            return fail(path, title + "was cut short or altered: its digest does not match");
        }
#endif
        if (const std::string problem = load(table, bytes); !problem.empty()) return fail(path, title + problem);
        if (const std::string problem = contents_fault(table); !problem.empty()) return fail(path, title + problem);
    }
    return true;
}

inline std::string Bank::read_body(const detail::Bytes& manifest, Digests& digests) {
    using detail::Value;
    if (manifest.size() > detail::LARGEST_MANIFEST) return "the manifest is too large";
    const Value outer = Value::at(manifest.data(), manifest.data() + manifest.size());
    const Value packed = outer["body"];
    std::string format;
    std::int64_t version = 0;
    if (outer.next() != manifest.data() + manifest.size() || packed.type == Value::Type::invalid ||
        !get(outer["digest"], digest_) || !get(outer["format"], format) || !get(outer["version"], version)) {
        return "the manifest is cut short or damaged";
    }
    if (format != detail::FORMAT || version != detail::VERSION) {
        return "expected version " + std::to_string(detail::VERSION) + " of " + detail::quoted(detail::FORMAT) +
               ", found version " + std::to_string(version) + " of " + detail::quoted(format);
    }
    bool sound = packed.type == Value::Type::binary;
#ifndef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
    sound = sound && detail::Blake2b::digest(packed.body, static_cast<std::size_t>(packed.size)) == digest_;
#endif
    if (!sound) return "the manifest was altered: its digest does not match";
    const Value body = Value::at(packed.body, packed.body + packed.size);
    if (body.type != Value::Type::map || body.next() != body.end) return "the manifest is not a map";

    if (const std::string problem = read_skeleton(body["skeleton"]); !problem.empty()) return problem;
    if (const std::string problem = read_clips(body); !problem.empty()) return problem;
    for (std::size_t table = 0; table < digests.size(); ++table) {
        const bool found = get(body["tables"][detail::TABLES[table]], digests[table]) && digests[table].size() == 32 &&
                           digests[table].find_first_not_of("0123456789abcdef") == std::string::npos;
        if (!found) return "the manifest has no digest of table " + detail::quoted(detail::TABLES[table]);
    }
    if (const std::string problem = read_roles(body["roles"]); !problem.empty()) return problem;
    return read_mirror(body["mirror"]);
}

/// Reads the skeleton. Like all that follow, returns a problem; empty if there is none.
inline std::string Bank::read_skeleton(const detail::Value& rig) {
    if (!get(rig["names"], skeleton_.names) || !get(rig["parents"], skeleton_.parents) ||
        !get(rig["offsets"], skeleton_.offsets) || !get(rig["end_parents"], skeleton_.end_parents) ||
        !get(rig["end_offsets"], skeleton_.end_offsets)) {
        return "the manifest has a missing or invalid field ('skeleton')";
    }
    const std::size_t count = skeleton_.names.size(), most = std::numeric_limits<std::int32_t>::max() / 64;
    if (count == 0 || count > most) return "the skeleton has no joints, or too many";
    if (skeleton_.parents.size() != count || skeleton_.offsets.size() != count) {
        return "every joint needs one parent and one offset";
    }
    for (std::size_t joint = 0; joint < count; ++joint) {
        const std::int64_t parent = skeleton_.parents[joint];
        if (joint == 0 ? parent != -1 : parent < 0 || parent >= static_cast<std::int64_t>(joint)) {
            return "joints must be ordered parent before child, below a single root";
        }
    }
    std::vector<std::string> names = skeleton_.names;
    std::sort(names.begin(), names.end());
    if (std::adjacent_find(names.begin(), names.end()) != names.end()) return "two joints have the same name";
    if (skeleton_.end_parents.size() != skeleton_.end_offsets.size()) {
        return "every end site needs one parent and one offset";
    }
    for (const std::int64_t parent : skeleton_.end_parents) {
        if (parent < 0 || parent >= joint_count()) return "the parent of an end site does not exist";
    }
    return "";
}

inline std::string Bank::read_clips(const detail::Value& body) {
    using detail::Fields;
    using detail::Value;
    std::string baseline, problem;
    double start = 0.0, end = 0.0, loop = 0.0;
    std::int64_t cells = 0;
    Fields of_baseline(body["baseline"]);
    of_baseline("clip", baseline)("start", start)("end", end)("loop", loop)("cells", cells);
    problem = of_baseline.fault();
    if (!problem.empty()) return problem;
    const bool all_clips = body["clips"].each([&](const Value& item) {
        ClipEntry& clip = clips_.emplace_back();
        Fields fields(item);
        fields("name", clip.name)("kind", clip.kind)("tags", clip.tags)("source", clip.source);
        fields("warnings", clip.warnings)("notes", clip.notes)("rate", clip.rate)("gait", clip.gait)("loop", clip.loop);
        fields("first_row", clip.first_row)("frame_count", clip.frame_count)("row_count", clip.row_count);
        fields("first_cell", clip.first_cell)("cell_count", clip.cell_count)("cycles", clip.cycles);
        fields("first_phase", clip.first_phase)("last_phase", clip.last_phase);
        fields("mean_mismatch", clip.mean_mismatch)("worst_mismatch", clip.worst_mismatch);
        fields("shoulder_motion", clip.shoulder_motion)("repetition", clip.repetition)("stance", clip.stance)("parts", clip.parts)("uses", clip.uses);
        fields("stretches", clip.stretches)("enters", clip.enters)("leaves", clip.leaves);
        problem = fields.fault();
        return problem.empty();
    });
    const bool all_hands = problem.empty() && body["hands"].each([&](const Value& item) {
        HandsEntry& one = hands_.emplace_back();
        Fields fields(item);
        fields("name", one.name)("body", one.body)("first_row", one.first_row)("rate", one.rate)("hand", one.hand);
        fields("wrist", one.wrist)("pairs", one.pairs)("mismatch", one.mismatch)("warnings", one.warnings);
        fields("source", one.source);
        problem = fields.fault();
        return problem.empty();
    });
    if (!problem.empty()) return problem;
    if (!all_clips || !all_hands) return "the manifest has a missing or invalid field ('clips' or 'hands')";
    if (problem = clips_fault(baseline); !problem.empty()) return problem;
    if (problem = link_stretches(); !problem.empty()) return problem;
    return hands_fault();
}

inline std::string Bank::read_roles(const detail::Value& map) {
    std::array<std::int64_t, 18> roles{};
    std::vector<std::int64_t> spine;
    constexpr std::array<const char*, 18> ROLES = {
        "root", "pelvis", "neck", "head", "left_hip", "left_knee", "left_ankle", "left_toe", "right_hip", "right_knee",
        "right_ankle", "right_toe", "left_shoulder", "left_elbow", "left_wrist", "right_shoulder", "right_elbow",
        "right_wrist"};
    detail::Fields fields(map);
    fields("spine", spine);
    for (std::size_t i = 0; i < ROLES.size(); ++i) fields(ROLES[i], roles[i]);
    if (const std::string problem = fields.fault(); !problem.empty()) return problem;
    const auto is_joint = [&](std::int64_t joint) { return joint >= -1 && joint < joint_count(); };
    pelvis_ = roles[1];
    if (pelvis_ < 1 || !std::all_of(roles.begin(), roles.end(), is_joint) ||
        !std::all_of(spine.begin(), spine.end(), is_joint)) {
        return "a role refers to a joint that does not exist";
    }
    points_ = static_cast<std::int64_t>(spine.size()) + 2;
    lay_out(roles[13], roles[16]);
    find_parts(roles[12], roles[15], roles[2] >= 0 ? roles[2] : roles[3]);
    return "";
}

/// Adds the mirror images of the clips, and reads how the rig is mirrored.
inline std::string Bank::read_mirror(const detail::Value& map) {
    numbered_ = clips_;
    for (const ClipEntry& clip : clips_) {
        ClipEntry& image = numbered_.emplace_back(clip);
        image.name += detail::MIRRORED;
        image.first_phase += detail::HALF_A_CYCLE, image.last_phase += detail::HALF_A_CYCLE;
        image.mirrored = true;
        for (std::string& stretch : image.stretches) stretch += detail::MIRRORED;
        for (int* number : {&image.first_stretch, &image.next_stretch}) {
            if (*number != NOT_FOUND) *number += static_cast<int>(clips_.size());
        }
        image.parts = (clip.parts & 9) | (clip.parts & 2) << 1 | (clip.parts & 4) >> 1;
        for (std::string& use : image.uses) {
            use = use == "left arm" ? "right arm" : use == "right arm" ? "left arm" : use;
        }
        std::sort(image.uses.begin(), image.uses.end(), [](const std::string& a, const std::string& b) {
            return detail::part_named(a) < detail::part_named(b);
        });
    }
    if (map.type == detail::Value::Type::nil) return "";
    std::vector<std::int64_t> twins;
    std::vector<Turn> turns;
    const std::string problem = detail::Fields(map)("twins", twins)("turns", turns).fault();
    if (!problem.empty()) return problem;
    const std::size_t count = skeleton_.names.size(), pelvis = std::size_t(pelvis_);
    if (twins.size() != count || turns.size() != count) {
        return "the manifest's mirror does not fit " + std::to_string(count) + " joints";
    }
    const bool middle = twins[pelvis] == -1 || twins[pelvis] == pelvis_;
    if (!middle || !mirror_half(lower_half_, twins, turns, lower_images_) ||
        !mirror_half(upper_half_, twins, turns, upper_images_)) {
        return "the mirror has a twin in the other half of the body";
    }
    const double back[4] = {-turns[pelvis][0], -turns[pelvis][1], -turns[pelvis][2], turns[pelvis][3]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::array<double, 3> unit{};
        unit[axis] = axis == 0 ? -1.0 : 1.0;
        const std::array<double, 3> column = detail::rotated(back, unit);
        for (std::size_t i = 0; i < 3; ++i) cloud_image_[i][axis] = column[i];
    }
    return "";
}

/// Finds how a half is mirrored. Returns whether the twins of its joints lie in it.
inline bool Bank::mirror_half(const detail::Half& half, const std::vector<std::int64_t>& twins,
                              const std::vector<Turn>& turns, detail::Images& images) const {
    constexpr Turn IDENTITY = {0.0, 0.0, 0.0, 1.0};
    const auto above = [&](std::size_t joint) {
        return joint == 0 ? IDENTITY : turns[std::size_t(skeleton_.parents[joint])];
    };
    std::vector<int> lanes(twins.size(), -1);  // of the half's joints
    for (std::size_t i = 0; i < half.joints.size(); ++i) {
        lanes[std::size_t(half.joints[i])] = static_cast<int>(detail::FIRST_JOINT + i);
    }
    for (int lane = 0; lane < half.width; ++lane) images.twins.push_back(lane);
    images.matrices.assign(images.twins.size(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    const auto pelvis = static_cast<std::size_t>(pelvis_);
    images.matrices[detail::PELVIS] = detail::image(above(pelvis), turns[pelvis]);
    images.matrices[detail::POSTURE_FRAME] = detail::image(above(pelvis), IDENTITY);
    images.matrices[detail::TORSO_OFFSET] = detail::image(IDENTITY, IDENTITY);
    for (const int number : half.joints) {
        const auto joint = static_cast<std::size_t>(number), lane = static_cast<std::size_t>(lanes[joint]);
        const std::int64_t twin = twins[joint];
        if (twin == -1) continue;
        if (twin < 0 || twin >= joint_count() || lanes[std::size_t(twin)] < 0) return false;
        images.twins[lane] = lanes[std::size_t(twin)];
        images.matrices[lane] = detail::image(above(joint), turns[joint]);
    }
    return true;
}

inline std::string Bank::clips_fault(const std::string& baseline) {
    for (const ClipEntry& clip : clips_) {
        const double cycles = clip.last_phase - clip.first_phase;
        const bool follows = clip.first_row == rows_ && clip.first_cell == cells_;
        const bool sized = clip.frame_count >= 2 && clip.row_count >= clip.frame_count && clip.cell_count >= 2 &&
                           clip.row_count < detail::MOST_ROWS && clip.cell_count < detail::MOST_ROWS;
        const bool stood = (clip.stance == -1 || clip.stance == stances_) && clip.parts >= 0 && clip.parts < 16;
        const bool timed = clip.rate > 0.0 && clip.rate < 1e6 && cycles < 1e9 && clip.loop >= 0;
        if (!follows || !sized || !stood || !timed || static_cast<double>(clip.loop) >= cycles) {
            return "the entry of clip " + detail::quoted(clip.name) + " does not match the tables";
        }
        stances_ += clip.stands();
        rows_ += clip.row_count, cells_ += clip.cell_count;
        if (rows_ > detail::MOST_ROWS || cells_ > detail::MOST_ROWS) return "the clips have too many rows";
        by_name_.push_back(static_cast<int>(by_name_.size()));
    }
    const auto before = [&](int a, int b) { return clips_[std::size_t(a)].name < clips_[std::size_t(b)].name; };
    const auto same = [&](int a, int b) { return clips_[std::size_t(a)].name == clips_[std::size_t(b)].name; };
    std::sort(by_name_.begin(), by_name_.end(), before);
    if (clips_.empty() || std::adjacent_find(by_name_.begin(), by_name_.end(), same) != by_name_.end()) {
        return "the bank has no clips, or two clips of the same name";
    }
    return find_own(baseline) == NOT_FOUND ? "the baseline is a clip that does not exist" : "";
}

/// Finds the numbers of all stretches. Returns a problem if they do not match the clips.
inline std::string Bank::link_stretches() {
    std::vector<bool> used(clips_.size());
    for (std::size_t hybrid = 0; hybrid < clips_.size(); ++hybrid) {
        int before = NOT_FOUND;
        for (const std::string& name : clips_[hybrid].stretches) {
            const int number = find_own(name);
            const ClipEntry* one = number == NOT_FOUND ? nullptr : &clips_[std::size_t(number)];
            const bool fits = one && one->stretches.empty() && one->enters >= 0.0 && one->enters < one->leaves &&
                              one->leaves <= static_cast<double>(one->frame_count - 1);
            if (!fits || used[std::size_t(number)]) {
                return "the stretch " + detail::quoted(name) + " of clip " + detail::quoted(clips_[hybrid].name) +
                       " does not match the clips";
            }
            (before == NOT_FOUND ? clips_[hybrid].first_stretch : clips_[std::size_t(before)].next_stretch) = number;
            before = number;
            used[std::size_t(number)] = has_stretches_ = true;
        }
    }
    return "";
}

inline std::string Bank::hands_fault() {
    for (const HandsEntry& one : hands_) hand_clips_.push_back(one.name);
    std::sort(hand_clips_.begin(), hand_clips_.end());
    hand_clips_.erase(std::unique(hand_clips_.begin(), hand_clips_.end()), hand_clips_.end());
    for (const HandsEntry& one : hands_) {
        const int body = find_own(one.body);
        if (body == NOT_FOUND || one.first_row != hand_rows_ || hand_rows_ > detail::MOST_ROWS) {
            return "the entry of hands " + detail::quoted(one.name) + " on " + detail::quoted(one.body) +
                   " does not match the tables";
        }
        hands_of_.push_back({{find_hands(one.name), body}, static_cast<int>(hands_of_.size())});
        hand_rows_ += clips_[std::size_t(body)].row_count;
    }
    std::sort(hands_of_.begin(), hands_of_.end());
    const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
    const bool twice = std::adjacent_find(hands_of_.begin(), hands_of_.end(), same) != hands_of_.end();
    return twice ? "two hands of the same name lie on one clip" : "";
}

/// Finds the joints of both halves and of the hands, and the columns of their tables.
inline void Bank::lay_out(std::int64_t left_elbow, std::int64_t right_elbow) {
    const std::size_t count = skeleton_.names.size();
    std::vector<char> above(count), driven(count);
    for (std::size_t joint = 0; joint < count; ++joint) {
        const auto number = static_cast<std::int64_t>(joint);
        const std::int64_t parent = skeleton_.parents[joint];
        above[joint] = number == pelvis_ || (parent >= 0 && above[std::size_t(parent)]);
        driven[joint] = number == left_elbow || number == right_elbow || (parent >= 0 && driven[std::size_t(parent)]);
        if (number == pelvis_) continue;
        if (above[joint] && driven[joint]) {
            hands_half_.joints.push_back(static_cast<int>(joint));
            lanes_of_hands_.push_back(static_cast<int>(detail::FIRST_JOINT + upper_half_.joints.size()));
        }
        (above[joint] ? upper_half_ : lower_half_).joints.push_back(static_cast<int>(joint));
    }
    cloud_width_ = detail::whole(points_, detail::LANES);
    const std::int64_t first_plane = detail::whole(detail::CLOUD + 3 * cloud_width_, detail::LANES);
    lower_half_.lay_out(first_plane, detail::FIRST_JOINT);
    upper_half_.lay_out(first_plane, detail::FIRST_JOINT);
    hands_half_.lay_out(0, 0);
}

/// Returns a joint and all above it, from the joint up; nothing for no joint.
inline std::vector<std::int64_t> Bank::chain(std::int64_t joint) const {
    std::vector<std::int64_t> found;
    for (; joint >= 0; joint = skeleton_.parents[std::size_t(joint)]) found.push_back(joint);
    return found;
}

/// Finds the part of the upper body that each lane of `upper` belongs to: trunk, left arm, right arm or head.
inline void Bank::find_parts(std::int64_t left_shoulder, std::int64_t right_shoulder, std::int64_t head) {
    parts_of_lanes_.assign(std::size_t(upper_half_.width), 0);
    const auto has = [](const std::vector<std::int64_t>& joints, std::int64_t joint) {
        return std::find(joints.begin(), joints.end(), joint) != joints.end();
    };
    const std::vector<std::int64_t> left = chain(left_shoulder), right = chain(right_shoulder);
    const auto branch = std::find_if(left.begin(), left.end(), [&](std::int64_t joint) { return has(right, joint); });
    if (branch == left.end() || !has(chain(*branch), pelvis_)) return;
    const std::array<std::vector<std::int64_t>, 3> limbs = {left, right, chain(head)};
    for (std::size_t limb = 0; limb < limbs.size(); ++limb) {
        const auto at = std::find(limbs[limb].begin(), limbs[limb].end(), *branch);
        if (at == limbs[limb].end() || at == limbs[limb].begin()) continue;
        const std::int64_t first = *(at - 1);
        for (std::size_t i = 0; i < upper_half_.joints.size(); ++i) {
            if (has(chain(upper_half_.joints[i]), first)) {
                parts_of_lanes_[detail::FIRST_JOINT + i] = static_cast<unsigned char>(limb + 1);
            }
        }
    }
}

inline std::string Bank::load(std::size_t table, const detail::Bytes& file) {
    using detail::load;
    const auto clips = static_cast<std::int64_t>(clips_.size());
    switch (table) {
        case detail::LOWER: return load(file, {rows_, lower_half_.columns}, lower_);
        case detail::UPPER: return load(file, {rows_, upper_half_.columns}, upper_);
        case detail::PHASE_OF_FRAME: return load(file, {rows_}, phase_of_frame_);
        case detail::FRAME_OF_PHASE: return load(file, {cells_}, frame_of_phase_);
        case detail::PATHS: return load(file, {rows_, 4}, paths_);
        case detail::CONTACTS: return load(file, {rows_}, contacts_);
        case detail::FEET: return load(file, {rows_, 6}, feet_);
        case detail::POSTURES: return load(file, {clips, 2, 3}, postures_);
        case detail::NEUTRAL: return load(file, {clips}, neutral_);
        case detail::STANCES: return load(file, {stances_, upper_half_.columns}, stance_table_);
        case detail::HAND_FRAMES: return load(file, {hand_rows_, 2}, hand_frames_);
        default: break;
    }
    const std::string problem = load(file, {hand_rows_, hands_half_.columns}, hand_table_);
    if (problem.empty() || !load(file, {hand_rows_, 0}, hand_table_).empty()) return problem;
    hands_half_ = detail::Half();  // the rig has no fingers, so hands drive nothing
    return "";
}

inline std::string Bank::contents_fault(std::size_t table) const {
    switch (table) {
        case detail::LOWER: return detail::finite_fault(lower_);
        case detail::UPPER: return detail::finite_fault(upper_);
        case detail::FRAME_OF_PHASE: return detail::finite_fault(frame_of_phase_);
        case detail::PATHS: return detail::finite_fault(paths_);
        case detail::FEET: return detail::finite_fault(feet_);
        case detail::POSTURES: return detail::finite_fault(postures_);
        case detail::STANCES: return detail::finite_fault(stance_table_);
        case detail::HANDS: return detail::finite_fault(hand_table_);
        case detail::HAND_FRAMES: return detail::finite_fault(hand_frames_);
        case detail::CONTACTS: {
            const std::uint8_t* end = contacts_.data() + contacts_.count;
            const bool sound = std::all_of(contacts_.data(), end, [](std::uint8_t feet) { return feet <= 3; });
            return sound ? "" : "has bits of feet that do not exist";
        }
        case detail::NEUTRAL: {
            const auto count = static_cast<std::int64_t>(clips_.size());
            const auto is_clip = [&](std::int32_t clip) { return clip >= 0 && clip < count; };
            const bool sound = std::all_of(neutral_.data(), neutral_.data() + neutral_.count, is_clip);
            return sound ? "" : "refers to a clip that does not exist";
        }
        default: break;
    }
    for (const ClipEntry& clip : clips_) {
        const double* phase = phase_of_frame_.data() + clip.first_row;
        const double last = phase[clip.row_count - 1];
        if (phase[0] != clip.first_phase || last != clip.last_phase || !(phase[0] >= -1e9 && last <= 1e9)) {
            return "does not match the phases of the clips";
        }
        for (std::int64_t row = 1; row < clip.row_count; ++row) {
            if (!(phase[row] > phase[row - 1])) return "does not increase within a clip";
        }
    }
    return "";
}

inline int Bank::find(std::string_view clip) const {
    const int own = find_own(clip), count = static_cast<int>(clips_.size());
    const std::size_t length = clip.size() - std::min(clip.size(), detail::MIRRORED.size());
    if (own != NOT_FOUND || clip.substr(length) != detail::MIRRORED) return own;
    const int image_of = find_own(clip.substr(0, length));
    return image_of == NOT_FOUND ? NOT_FOUND : image_of + count;
}

/// Returns the number of a clip that is no mirror image.
inline int Bank::find_own(std::string_view clip) const {
    const auto before = [&](int number, std::string_view name) { return clips_[std::size_t(number)].name < name; };
    const auto found = std::lower_bound(by_name_.begin(), by_name_.end(), clip, before);
    return found != by_name_.end() && clips_[std::size_t(*found)].name == clip ? *found : NOT_FOUND;
}

inline int Bank::find_hands(std::string_view name) const {
    const auto found = std::lower_bound(hand_clips_.begin(), hand_clips_.end(), name);
    return found != hand_clips_.end() && *found == name ? static_cast<int>(found - hand_clips_.begin()) : NOT_FOUND;
}

/// Returns the first row in the table of hands of a hands clip on a clip; -1 if it is not aligned to it.
inline std::int64_t Bank::hand_row(int hands, int clip) const {
    const std::pair<std::pair<int, int>, int> wanted = {{hands, own(clip)}, 0};
    const auto found = std::lower_bound(hands_of_.begin(), hands_of_.end(), wanted);
    return found != hands_of_.end() && found->first == wanted.first ? hands_[std::size_t(found->second)].first_row : -1;
}

/// Returns the rows at a real-valued frame of a clip, clamped to 0 to `last`.
inline detail::Between Bank::between(int clip, double frame, double last) const {
    frame = frame > 0.0 ? std::min(frame, last) : 0.0;  // NaN becomes 0 too
    const double before = std::min(std::floor(frame), last - 1.0);
    return {this->clip(clip).first_row + static_cast<std::int64_t>(before), frame - before};
}

inline double Bank::phase_at(int clip, detail::Between at) const {
    const double* phase = phase_of_frame_.data() + at.row;
    return phase[0] + at.share * (phase[1] - phase[0]) + (this->clip(clip).mirrored ? detail::HALF_A_CYCLE : 0.0);
}

/// Returns a clip's frame at a phase, as exactly as the cells of frame_of_phase allow.
inline double Bank::guess(int number, double phase) const {
    const ClipEntry& clip = this->clip(number);
    const double last = static_cast<double>(clip.cell_count - 1);
    double cell = (phase - clip.first_phase) * last / (clip.last_phase - clip.first_phase);
    cell = cell > 0.0 ? std::min(cell, last) : 0.0;
    const double before = std::min(std::floor(cell), last - 1.0);
    const float* frames = frame_of_phase_.data() + clip.first_cell + static_cast<std::int64_t>(before);
    return frames[0] + (cell - before) * (static_cast<double>(frames[1]) - frames[0]);
}

/// Returns a clip's exact frame at a phase, found from a frame near it; 0 or the last row if the phase lies outside.
inline double Bank::frame_at(int number, double phase, double near) const {
    const ClipEntry& clip = this->clip(number);
    const double* phases = phase_of_frame_.data() + clip.first_row;
    const double last = static_cast<double>(clip.row_count - 1);
    phase -= clip.mirrored ? detail::HALF_A_CYCLE : 0.0;
    std::int64_t row = between(number, near, last).row - clip.first_row;
    while (row > 0 && phase < phases[row]) --row;
    while (row < clip.row_count - 2 && phase > phases[row + 1]) ++row;
    const double share = (phase - phases[row]) / (phases[row + 1] - phases[row]);
    return static_cast<double>(row) + std::min(std::max(share, 0.0), 1.0);
}

/// Returns the mean places of the left and of the right shoulder.
inline std::array<double, 6> Bank::posture(int clip) const {
    const double* p = postures_.data() + 6 * std::ptrdiff_t(own(clip));
    if (this->clip(clip).mirrored) return {-p[3], p[4], p[5], -p[0], p[1], p[2]};
    return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

// ------------------------------------------------------------------------------------------------------- the evaluator

/// Returns the frame that a clip shows after so many seconds at its own speed. At its end it goes on as its loop does.
inline double Bank::own_frame(int number, double seconds) const {
    const ClipEntry& entry = clip(number);
    const double frame = seconds * entry.rate, last = static_cast<double>(entry.row_count - 1);
    if (frame <= last || entry.loop == 0) return std::min(frame, last);
    const double lasting = frames_in_loop(number);
    return std::min(frame - lasting * std::ceil((frame - last) / lasting), last);
}

/// Returns how many frames a clip with a loop goes back at its last row.
inline double Bank::frames_in_loop(int number) const {
    const ClipEntry& entry = clip(number);
    const double phase = entry.last_phase - static_cast<double>(entry.loop);
    return static_cast<double>(entry.row_count - 1) - frame_at(number, phase, guess(number, phase));
}

/// Returns a clip's phase at a frame.
inline double Bank::phase_of(int number, double frame) const {
    return phase_at(number, between(number, frame, static_cast<double>(clip(number).row_count - 1)));
}

/// Returns the phase of a clip so many seconds after its start, through all its loops.
inline double Bank::unrolled_phase(int number, double seconds) const {
    const ClipEntry& entry = clip(number);
    double frame = seconds * entry.rate, rounds = 0.0;
    if (entry.loop == 0) return phase_of(number, std::min(frame, entry.last_frame()));
    if (frame > entry.last_frame()) {
        const double lasting = frames_in_loop(number);
        rounds = std::ceil((frame - entry.last_frame()) / lasting);
        frame -= rounds * lasting;
    }
    return phase_of(number, frame) + rounds * static_cast<double>(entry.loop);
}

/// Returns the time of such a phase; infinite if the clip ends before.
inline double Bank::seconds_at(int number, double phase) const {
    const ClipEntry& entry = clip(number);
    const double loop = static_cast<double>(entry.loop);
    double rounds = 0.0;
    if (phase > entry.last_phase) {
        if (entry.loop == 0) return std::numeric_limits<double>::infinity();
        rounds = std::ceil((phase - entry.last_phase) / loop);
        phase -= rounds * loop;
    }
    const double frame = frame_at(number, phase, guess(number, phase));
    return (frame + (rounds > 0.0 ? rounds * frames_in_loop(number) : 0.0)) / entry.rate;
}

/// Where one character of a block is in the tables.
struct Evaluator::Character {
    detail::Between lower, upper;
    double phase = 0.0, near = 0.0;  // of the action
    int upper_clip = 0;              // the clip that gives the upper body
    std::int64_t hand_row = -1;      // the row of the hands; -1 without hands
    Method method = Method::none;
    bool lower_mirrored = false, upper_mirrored = false;
    bool own_clock = false, added = false;  // of an action captured standing; if added, the method is naive
};

/// What the pelves of a block are turned by.
struct Evaluator::Torsos {
    detail::Correlations<BLOCK> clouds;
    detail::Quaternions<BLOCK> pelves = {}, frames = {}, own_offsets = {}, their_offsets = {};
};

inline Evaluator::Evaluator(const Bank& bank)
    : bank_(&bank),
      lower_lanes_(std::size_t(4 * bank.lower_half_.width)),
      upper_lanes_(std::size_t(4 * bank.upper_half_.width)),
      hand_lanes_(std::size_t(4 * bank.hands_half_.width)),
      own_lanes_(upper_lanes_.size()),
      stance_lanes_(upper_lanes_.size()),
      spare_lanes_(std::max(lower_lanes_.size(), upper_lanes_.size())),
      world_(std::size_t(7 * detail::LANES) * bank.skeleton_.names.size()),
      faded_(4 * bank.skeleton_.names.size()) {}

inline Error Evaluator::pose(const Splice& splice, double time, float* rotations, float* root_position,
                             Memory* memory) {
    return poses(&splice, &time, 1, rotations, root_position, memory);
}

inline Error Evaluator::poses(const Splice* splices, const double* times, int count, float* rotations,
                              float* root_positions, Memory* memories) {
    for (int k = 0; k < count; ++k) {
        Error error = fault(splices[k], times[k], memories != nullptr);
        if (error && count > 1) error.place = "character " + std::to_string(k);
        if (error) return error;
    }
    const std::ptrdiff_t width = 4 * std::ptrdiff_t(bank_->joint_count());
    for (int first = 0; first < count; first += BLOCK) {
        const int block = std::min(BLOCK, count - first);
        float* block_rotations = rotations + first * width;
        float* block_roots = root_positions + 3 * std::ptrdiff_t(first);
        Memory* block_memories = memories ? memories + first : nullptr;
        if (!bank_->has_stretches_) {
            evaluate(splices + first, times + first, block, block_rotations, block_roots, block_memories);
            continue;
        }
        Splice now[BLOCK], before[BLOCK];
        Memory remembered[BLOCK];
        double shares[BLOCK];
        for (int k = 0; k < block; ++k) {
            const Splice& splice = now[k] = before[k] = splices[first + k];
            const bool hybrid = splice.action != NOTHING && splice.method == Method::splice &&
                                bank_->clip(splice.action).first_stretch != NOT_FOUND;
            shares[k] = hybrid ? find_stretch(splice, times[first + k], now[k], before[k]) : 1.0;
            if (memories) remembered[k] = block_memories[k];
        }
        evaluate(now, times + first, block, block_rotations, block_roots, block_memories);
        for (int k = 0; k < block; ++k) {
            if (shares[k] == 1.0) continue;
            blend(before[k], times[first + k], shares[k], block_rotations + k * width, block_roots + 3 * k,
                  memories ? &remembered[k] : nullptr);
        }
    }
    return Error();
}

/// Evaluates a block of valid splices that are no hybrids.
inline void Evaluator::evaluate(const Splice* splices, const double* times, int count, float* rotations,
                                float* root_positions, Memory* memories) {
    const std::ptrdiff_t width = 4 * std::ptrdiff_t(bank_->joint_count());
    Character characters[BLOCK];
    Torsos torsos;
    look_up(splices, times, count, characters);
    bool any = false;
    for (int k = 0; k < count; ++k) {
        sample(characters[k], rotations + k * width, root_positions + 3 * k);
        if (characters[k].method != Method::splice) continue;
        correlate(characters[k], k, torsos);
        any = true;
    }
    if (!any) return;
    turn_pelves(splices, characters, count, torsos, memories);
    for (int k = 0; k < count; ++k) {
        if (characters[k].method != Method::splice) continue;
        double q[4];
        torsos.pelves.get(k, q);
        const double scale = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        float* pelvis = rotations + k * width + 4 * bank_->pelvis_;
        for (int i = 0; i < 4; ++i) pelvis[i] = static_cast<float>(q[i] * scale);
    }
}

/// Blends a pose with that of the stretch which is faded out below it.
inline void Evaluator::blend(const Splice& before, double time, double share, float* rotations, float* root_position,
                             const Memory* memory) {
    Memory remembered = memory ? *memory : Memory();
    evaluate(&before, &time, 1, faded_.data(), root_position, memory ? &remembered : nullptr);
    for (std::size_t joint = 0; joint < faded_.size(); joint += 4) {
        double q[4], dot = 0.0, square = 0.0;
        for (std::size_t i = 0; i < 4; ++i) dot += double(rotations[joint + i]) * double(faded_[joint + i]);
        for (std::size_t i = 0; i < 4; ++i) {
            const double other = dot < 0.0 ? share - 1.0 : 1.0 - share;
            q[i] = share * double(rotations[joint + i]) + other * double(faded_[joint + i]);
            square += q[i] * q[i];
        }
        for (std::size_t i = 0; i < 4; ++i) rotations[joint + i] = static_cast<float>(q[i] / std::sqrt(square));
    }
}

/// Fills in splices of the stretch of a hybrid that is shown, and of the one before; returns the share of the former.
inline double Evaluator::find_stretch(const Splice& splice, double time, Splice& now, Splice& before) const {
    const Bank& bank = *bank_;
    const ClipEntry& below = bank.clip(splice.locomotion);
    const std::int64_t cycles = below.loop > 0 ? splice.cycles : 0;
    if (cycles != 0) {
        const double strides = static_cast<double>(cycles) / static_cast<double>(below.loop);
        time = std::max(time + strides * bank.frames_in_loop(splice.locomotion) / below.rate, 0.0);
    }
    const ClipEntry& hybrid = bank.clip(splice.action);
    int number = hybrid.first_stretch;
    double ahead = splice.start * hybrid.rate, begun = 0.0;
    for (const ClipEntry* one = &bank.clip(number); one->next_stretch != NOT_FOUND; one = &bank.clip(number)) {
        if (ahead < one->leaves - one->enters) break;
        ahead -= one->leaves - one->enters;
        number = one->next_stretch;
    }
    for (double frame = bank.clip(number).enters + ahead;; frame = bank.clip(number).enters) {
        const ClipEntry& one = bank.clip(number);
        now.action = number, now.cycles = splice.cycles;
        double ends = 0.0;
        if (one.stands()) {
            now.start = frame / one.rate - begun;
            ends = begun + (one.leaves - frame) / one.rate;
        } else {
            const double start = bank.phase_of(number, frame), phase = bank.unrolled_phase(splice.locomotion, begun);
            double shift = std::ceil(start - phase - detail::IN_STEP);
            if (begun > 0.0) shift = std::ceil(start - phase - detail::EARLIER);
            if (begun > 0.0 && phase + shift < one.first_phase) shift += 1.0;
            now.start = 0.0;
            now.cycles = cycles + static_cast<std::int64_t>(
                                      shift - std::ceil(one.first_phase - below.first_phase - detail::IN_STEP));
            ends = bank.seconds_at(splice.locomotion, bank.phase_of(number, one.leaves) - shift);
        }
        ends = std::max(ends, begun + detail::HANDOVER);
        if (one.next_stretch == NOT_FOUND || time < ends) {
            const double t = std::min((time - begun) / detail::HANDOVER, 1.0);
            return begun == 0.0 ? 1.0 : t * t * (3.0 - 2.0 * t);
        }
        before = now;
        number = one.next_stretch;
        begun = ends;
    }
}

inline bool Evaluator::exists(int clip) const {
    const std::size_t count = bank_->has_mirror_images() ? bank_->numbered_.size() : bank_->clips_.size();
    return clip >= 0 && static_cast<std::size_t>(clip) < count;
}

inline Error Evaluator::fault(const Splice& splice, double time, bool remembers) const {
    const auto settings = [](std::string problem, const char* mend) {
        return Error{Error::Kind::settings, "", "", std::move(problem), mend};
    };
    const auto outside = [](const char* label, double seconds, const ClipEntry& clip, double end) {
        const std::string last = std::to_string(end), what = label;
        std::string problem = what + " " + std::to_string(seconds) + " s lies outside clip ";
        problem += detail::quoted(clip.name) + ", which lasts " + last + " s";
        return Error{Error::Kind::time_range, "", "", std::move(problem), "Give a " + what + " from 0 to " + last};
    };
    const auto within = [](double seconds, double last, double rate) {
        return seconds >= 0.0 && (seconds - detail::LATE) * rate <= last;
    };
    const int action = splice.action == NOTHING ? splice.locomotion : splice.action;
    for (const int clip : {splice.locomotion, action}) {
        if (exists(clip)) continue;
        if (clip >= 0 && static_cast<std::size_t>(clip) < bank_->numbered_.size()) {
            return settings("the bank has no clip " + detail::quoted(bank_->clip(clip).name),
                            "Its rig has no mirror image, because left and right limbs hang on different joints");
        }
        return settings("the bank has no clip number " + std::to_string(clip), "Find its number with Bank::find");
    }
    if (splice.method > Method::splice || splice.posture > Posture::running) {
        return settings("unknown method or posture", "Use the values of Method and Posture");
    }
    const bool spliced = splice.action != NOTHING && splice.method == Method::splice;
    if (spliced && splice.posture == Posture::running && !remembers) {
        return settings("posture running is a mean over earlier frames and needs a memory of them",
                        "Evaluate frame by frame with a Memory");
    }
    const int upper = splice.method == Method::none ? splice.locomotion : action;
    bool fits = splice.hands == NOTHING || bank_->hand_row(splice.hands, upper) >= 0;
    for (int one = bank_->clip(upper).first_stretch; fits && spliced && splice.hands != NOTHING && one != NOT_FOUND;
         one = bank_->clip(one).next_stretch) {
        fits = bank_->hand_row(splice.hands, one) >= 0;
    }
    if (!fits) {
        const std::string name = detail::quoted(bank_->clip(upper).name);
        return settings("hands number " + std::to_string(splice.hands) + " are not aligned to clip " + name,
                        "Find their number with Bank::find_hands");
    }
    const ClipEntry& below = bank_->clip(splice.locomotion);
    const ClipEntry& above = bank_->clip(action);
    if (!within(time, below.last_frame(), below.rate)) return outside("time", time, below, below.end());
    const double last = static_cast<double>(above.frame_count - 1);
    if (!within(splice.start, last, above.rate)) return outside("start", splice.start, above, above.duration());
    return Error();
}

inline void Evaluator::prefetch_upper(const Splice& splice, Character& character) const {
    const Bank& bank = *bank_;
    detail::prefetch(bank.upper_.data(), character.upper.row, bank.upper_half_);
    if (splice.hands == NOTHING) return;
    const std::int64_t row = character.upper.row - bank.clip(character.upper_clip).first_row;
    character.hand_row = bank.hand_row(splice.hands, character.upper_clip) + row;
    detail::prefetch(bank.hand_table_.data(), character.hand_row, bank.hands_half_);
}

/// Finds the rows of a block's characters. Each step is done for all before the next, so that their waits for memory
/// overlap.
inline void Evaluator::look_up(const Splice* splices, const double* times, int count, Character* characters) const {
    const Bank& bank = *bank_;
    for (int k = 0; k < count; ++k) {
        const Splice& splice = splices[k];
        const ClipEntry& below = bank.clip(splice.locomotion);
        Character& character = characters[k];
        character.method = splice.action == NOTHING ? Method::none : splice.method;
        character.upper_clip = character.method == Method::none ? splice.locomotion : splice.action;
        character.lower = bank.between(splice.locomotion, times[k] * below.rate, below.last_frame());
        detail::prefetch(bank.lower_.data(), character.lower.row, bank.lower_half_);
        const ClipEntry& above = bank.clip(character.upper_clip);
        character.lower_mirrored = below.mirrored, character.upper_mirrored = above.mirrored;
        const double last = static_cast<double>(above.frame_count - 1);
        if (character.method == Method::splice && above.stands()) {
            double seconds = splice.start + times[k];
            if (splice.cycles != 0 && below.loop > 0) {
                const double stride = bank.frames_in_loop(splice.locomotion) / static_cast<double>(below.loop);
                seconds = std::max(seconds + static_cast<double>(splice.cycles) * stride / below.rate, 0.0);
            }
            const double frame = bank.own_frame(character.upper_clip, seconds);
            character.upper = bank.between(character.upper_clip, frame, static_cast<double>(above.row_count - 1));
            character.own_clock = true, character.added = splice.posture == Posture::relative;
            if (character.added) character.method = Method::naive;
            detail::prefetch(bank.upper_.data(), character.lower.row, bank.upper_half_);
            prefetch_upper(splice, character);
        } else if (character.method == Method::splice) {
            const detail::Between start = bank.between(character.upper_clip, splice.start * above.rate, last);
            const double first = bank.phase_at(character.upper_clip, start);
            const double shift = std::ceil(first - below.first_phase - detail::IN_STEP);
            character.phase = bank.phase_at(splice.locomotion, character.lower) + shift;
            character.phase += static_cast<double>(splice.cycles);
            const double loop = static_cast<double>(above.loop), beyond = character.phase - above.last_phase;
            if (loop > 0.0 && beyond > 0.0) character.phase -= loop * std::ceil(beyond / loop);
        } else {
            const double frame = (splice.start + times[k]) * above.rate;
            const double wrapped = frame > last ? std::fmod(frame, last) : frame;
            const bool naive = character.method == Method::naive;
            character.upper = naive ? bank.between(character.upper_clip, wrapped, last) : character.lower;
            prefetch_upper(splice, character);
        }
    }
    for (int k = 0; k < count; ++k) {
        Character& character = characters[k];
        if (character.method != Method::splice || character.own_clock) continue;
        character.near = bank.guess(character.upper_clip, character.phase);
    }
    for (int k = 0; k < count; ++k) {
        Character& character = characters[k];
        if (character.method != Method::splice || character.own_clock) continue;
        const double last = static_cast<double>(bank.clip(character.upper_clip).row_count - 1);
        const double frame = bank.frame_at(character.upper_clip, character.phase, character.near);
        character.upper = bank.between(character.upper_clip, frame, last);
        prefetch_upper(splices[k], character);
    }
}

/// Samples both halves of a character: root and joints into its pose, all rotations into the lanes.
inline void Evaluator::sample(const Character& character, float* rotations, float* root_position) {
    const Bank& bank = *bank_;
    const auto put = [](const std::vector<float>& lanes, std::size_t lane, float* rotation) {
        const std::size_t width = lanes.size() / 4;
        for (std::size_t c = 0; c < 4; ++c) rotation[c] = lanes[c * width + lane];
    };
    const auto slerp = [](const float* table, std::int64_t row, const detail::Half& half, double share, float* lanes) {
        const float* planes = table + row * half.columns + half.first_plane;
        detail::slerp(planes, planes + half.columns, half.width, static_cast<float>(share), lanes);
    };
    const auto& [lower, upper, hands] = std::tie(bank.lower_half_, bank.upper_half_, bank.hands_half_);
    const float* root = bank.lower_.data() + character.lower.row * lower.columns + detail::ROOT;
    for (int axis = 0; axis < 3; ++axis) {
        const float here = root[axis], there = root[axis + lower.columns];
        root_position[axis] = here + static_cast<float>(character.lower.share) * (there - here);
    }
    const auto mirror = [this](const detail::Images& images, std::vector<float>& lanes) {
        std::copy(lanes.begin(), lanes.end(), spare_lanes_.begin());
        detail::mirror(images, spare_lanes_.data(), lanes.data());
    };
    slerp(bank.lower_.data(), character.lower.row, lower, character.lower.share, lower_lanes_.data());
    if (character.lower_mirrored) {
        root_position[0] = -root_position[0];
        mirror(bank.lower_images_, lower_lanes_);
    }
    slerp(bank.upper_.data(), character.upper.row, upper, character.upper.share, upper_lanes_.data());
    if (character.hand_row >= 0) {
        slerp(bank.hand_table_.data(), character.hand_row, hands, character.upper.share, hand_lanes_.data());
        const std::size_t from = hand_lanes_.size() / 4, to = upper_lanes_.size() / 4;
        for (std::size_t i = 0; i < hands.joints.size(); ++i) {
            const auto lane = static_cast<std::size_t>(bank.lanes_of_hands_[i]);
            for (std::size_t c = 0; c < 4; ++c) upper_lanes_[c * to + lane] = hand_lanes_[c * from + i];
        }
    }
    if (character.upper_mirrored) mirror(bank.upper_images_, upper_lanes_);
    if (character.added) {
        slerp(bank.upper_.data(), character.lower.row, upper, character.lower.share, own_lanes_.data());
        if (character.lower_mirrored) mirror(bank.upper_images_, own_lanes_);
        const std::int64_t stance = bank.clip(character.upper_clip).stance;
        const float* planes = bank.stance_table_.data() + stance * upper.columns + upper.first_plane;
        std::copy(planes, planes + stance_lanes_.size(), stance_lanes_.begin());
        if (character.upper_mirrored) mirror(bank.upper_images_, stance_lanes_);
        add(character);
    }
    for (std::size_t i = 0; i < lower.joints.size(); ++i) {
        put(lower_lanes_, detail::FIRST_JOINT + i, rotations + 4 * lower.joints[i]);
    }
    for (std::size_t i = 0; i < upper.joints.size(); ++i) {
        put(upper_lanes_, detail::FIRST_JOINT + i, rotations + 4 * upper.joints[i]);
    }
    const bool naive = character.method == Method::naive;
    put(naive ? upper_lanes_ : lower_lanes_, detail::PELVIS, rotations + 4 * bank.pelvis_);
}

/// Replaces the sampled upper half of an action captured standing by that of the splice.
inline void Evaluator::add(const Character& character) {
    const Bank& bank = *bank_;
    const detail::Half& upper = bank.upper_half_;
    const std::int64_t parts = bank.clip(character.upper_clip).parts;
    const float* row = bank.upper_.data() + character.upper.row * upper.columns + upper.first_plane - 4;
    std::array<double, 4> usage;
    for (std::size_t part = 0; part < 4; ++part) {
        const double here = row[part], there = row[part + std::size_t(upper.columns)];
        usage[part] = here + character.upper.share * (there - here);
    }
    if (character.upper_mirrored) std::swap(usage[1], usage[2]);
    const auto get = [](const std::vector<float>& lanes, std::size_t lane) {
        const std::size_t width = lanes.size() / 4;
        detail::Quaternions<1> q;
        const double numbers[4] = {lanes[lane], lanes[width + lane], lanes[2 * width + lane], lanes[3 * width + lane]};
        q.set(0, numbers);
        return q;
    };
    const auto put = [&](std::size_t lane, const std::array<double, 4>& q) {
        const std::size_t width = upper_lanes_.size() / 4;
        const double scale = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (std::size_t c = 0; c < 4; ++c) upper_lanes_[c * width + lane] = static_cast<float>(scale * q[c]);
    };
    std::array<double, 4> a, u;
    for (std::size_t i = 0; i < upper.joints.size(); ++i) {
        const std::size_t lane = detail::FIRST_JOINT + i, part = bank.parts_of_lanes_[lane];
        const auto own = get(own_lanes_, lane), posed = get(upper_lanes_, lane);
        if ((parts >> part & 1) == 0) {
            own.get(0, a.data());
        } else {
            product(own, product(inverse(get(stance_lanes_, lane)), posed)).get(0, a.data());
            posed.get(0, u.data());
            const double near = a[0] * u[0] + a[1] * u[1] + a[2] * u[2] + a[3] * u[3];
            const double share = near >= 0.0 ? usage[part] : -usage[part];
            for (std::size_t c = 0; c < 4; ++c) a[c] = (1.0 - usage[part]) * a[c] + share * u[c];
        }
        put(lane, a);
    }
    auto pelvis = get(lower_lanes_, detail::PELVIS);
    if (parts & 1) {
        const auto frame = get(lower_lanes_, detail::POSTURE_FRAME), turn = get(upper_lanes_, detail::TORSO_OFFSET);
        pelvis = product(product(product(frame, turn), inverse(frame)), pelvis);
    }
    pelvis.get(0, a.data());
    put(detail::PELVIS, a);
}

/// Writes the torso of a sampled splice into lane k.
inline void Evaluator::correlate(const Character& character, int k, Torsos& torsos) const {
    const auto set = [&](detail::Quaternions<BLOCK>& to, const std::vector<float>& lanes, std::size_t lane) {
        const std::size_t plane = lanes.size() / 4;
        to.x[k] = lanes[lane], to.y[k] = lanes[plane + lane];
        to.z[k] = lanes[2 * plane + lane], to.w[k] = lanes[3 * plane + lane];
    };
    set(torsos.pelves, lower_lanes_, detail::PELVIS);
    set(torsos.frames, lower_lanes_, detail::POSTURE_FRAME);
    set(torsos.own_offsets, lower_lanes_, detail::TORSO_OFFSET);
    set(torsos.their_offsets, upper_lanes_, detail::TORSO_OFFSET);
    if (character.lower_mirrored || character.upper_mirrored) return correlate_mirrored(character, k, torsos);
    constexpr int LANES = detail::LANES;
    const std::int64_t width = bank_->cloud_width_;
    const std::int64_t lower_columns = bank_->lower_half_.columns, upper_columns = bank_->upper_half_.columns;
    const float* lower = bank_->lower_.data() + character.lower.row * lower_columns + detail::CLOUD;
    const float* upper = bank_->upper_.data() + character.upper.row * upper_columns + detail::CLOUD;
    const auto t_lower = static_cast<float>(character.lower.share), t_upper = static_cast<float>(character.upper.share);
    float sums[3][3][LANES] = {};
    for (std::int64_t first = 0; first < width; first += LANES) {
        float a[3][LANES], b[3][LANES];
        for (std::int64_t axis = 0; axis < 3; ++axis) {
            const float* la = lower + axis * width + first;
            const float* ub = upper + axis * width + first;
            for (int p = 0; p < LANES; ++p) {
                a[axis][p] = la[p] + t_lower * (la[p + lower_columns] - la[p]);
                b[axis][p] = ub[p] + t_upper * (ub[p + upper_columns] - ub[p]);
            }
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                for (int p = 0; p < LANES; ++p) sums[i][j][p] += a[i][p] * b[j][p];
            }
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const float* s = sums[i][j];
            torsos.clouds.m[i][j][k] = ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
        }
    }
}

/// Writes the correlation of two clouds, of which either may be mirrored, into lane k.
inline void Evaluator::correlate_mirrored(const Character& character, int k, Torsos& torsos) const {
    const std::int64_t lower_columns = bank_->lower_half_.columns, upper_columns = bank_->upper_half_.columns;
    const float* lower = bank_->lower_.data() + character.lower.row * lower_columns;
    const float* upper = bank_->upper_.data() + character.upper.row * upper_columns;
    double sums[3][3] = {};
    for (std::int64_t number = 0; number < bank_->points_; ++number) {
        const auto a = point(lower, lower_columns, character.lower.share, character.lower_mirrored, number);
        const auto b = point(upper, upper_columns, character.upper.share, character.upper_mirrored, number);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) sums[i][j] += a[i] * b[j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) torsos.clouds.m[i][j][k] = sums[i][j];
    }
}

/// Returns a point of the upper cloud between two rows, or of its mirror image, in which the shoulders, the last two
/// points, change places.
inline std::array<double, 3> Evaluator::point(const float* rows, std::int64_t columns, double share, bool mirrored,
                                              std::int64_t number) const {
    const std::int64_t count = bank_->points_;
    const float* cloud = rows + detail::CLOUD + (mirrored && number >= count - 2 ? 2 * count - 3 - number : number);
    std::array<double, 3> at;
    for (std::int64_t axis = 0; axis < 3; ++axis) {
        const float* here = cloud + axis * bank_->cloud_width_;
        at[std::size_t(axis)] = here[0] + share * (double(here[columns]) - here[0]);
    }
    if (!mirrored) return at;
    std::array<double, 3> image;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::array<double, 3>& row = bank_->cloud_image_[i];
        image[i] = row[0] * at[0] + row[1] * at[1] + row[2] * at[2];
    }
    return image;
}

/// Turns the pelves of a block from the locomotion's rotations to the splices'.
inline void Evaluator::turn_pelves(const Splice* splices, const Character* characters, int count, Torsos& torsos,
                                   Memory* memories) const {
    constexpr double IDENTITY[4] = {0.0, 0.0, 0.0, 1.0};
    detail::Alignments<BLOCK> alignments = detail::align(torsos.clouds);
    for (int k = 0; k < count; ++k) {
        if (characters[k].method != Method::splice) continue;
        if (!alignments.clear[k]) alignments.turns.set(k, memories ? memories[k].turn : IDENTITY);
        if (memories) alignments.turns.get(k, memories[k].turn);
    }
    torsos.pelves = product(torsos.pelves, alignments.turns);

    detail::Quaternions<BLOCK> postures = product(torsos.their_offsets, inverse(torsos.own_offsets));
    detail::Correlations<BLOCK> shoulders;
    bool any = false;
    for (int k = 0; k < count; ++k) {
        const Posture posture = splices[k].posture;
        if (characters[k].method != Method::splice || posture == Posture::relative) continue;
        postures.set(k, IDENTITY);
        if (posture == Posture::off) continue;
        const std::array<double, 6> wanted = bank_->posture(splices[k].action);
        const std::array<double, 6> stored = bank_->posture(splices[k].locomotion);
        const double* given = stored.data();
        if (posture == Posture::running) {
            follow_posture(characters[k], given, k, torsos, memories[k]);
            given = memories[k].mean;
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                shoulders.m[i][j][k] = wanted[std::size_t(i)] * given[j] + wanted[std::size_t(3 + i)] * given[3 + j];
            }
        }
        any = true;
    }
    if (any) {
        const detail::Alignments<BLOCK> turned = detail::align(shoulders);
        for (int k = 0; k < count; ++k) {
            const bool asked = characters[k].method == Method::splice && splices[k].posture >= Posture::absolute;
            if (!asked || !turned.clear[k]) continue;
            double q[4];
            turned.turns.get(k, q);
            postures.set(k, q);
        }
    }
    const auto turns = product(product(torsos.frames, postures), inverse(torsos.frames));
    torsos.pelves = product(turns, torsos.pelves);
}

/// Updates the mean posture of a character by the shoulders of its splice, in the posture frame. `stored` begins it.
inline void Evaluator::follow_posture(const Character& character, const double* stored, int k, const Torsos& torsos,
                                      Memory& memory) const {
    if (!memory.begun) std::copy(stored, stored + 6, memory.mean);
    memory.begun = true;
    double turn[4];
    product(inverse(torsos.frames), torsos.pelves).get(k, turn);
    const std::int64_t columns = bank_->upper_half_.columns;
    const float* rows = bank_->upper_.data() + character.upper.row * columns;
    for (std::int64_t side = 0; side < 2; ++side) {  // the shoulders are the last two points
        const std::int64_t number = bank_->points_ - 2 + side;
        const std::array<double, 3> own = point(rows, columns, character.upper.share, character.upper_mirrored, number);
        const std::array<double, 3> shoulder = detail::rotated(turn, own);
        for (std::int64_t axis = 0; axis < 3; ++axis) {
            double& mean = memory.mean[3 * side + axis];
            mean += memory.share * (shoulder[std::size_t(axis)] - mean);
        }
    }
}

inline void Evaluator::world_positions(const float* rotations, const float* root_positions, int count,
                                       float* positions) {
    constexpr int LANES = detail::LANES;
    const int joints = bank_->joint_count();
    for (int first = 0; first < count; first += LANES) {
        std::ptrdiff_t of[LANES];  // characters past the last one repeat it
        for (int k = 0; k < LANES; ++k) of[k] = std::min(first + k, count - 1);
        for (std::ptrdiff_t joint = 0; joint < joints; ++joint) {
            float q[4][LANES], at[3][LANES];
            for (int k = 0; k < LANES; ++k) {
                for (int c = 0; c < 4; ++c) q[c][k] = rotations[(of[k] * joints + joint) * 4 + c];
            }
            float* own = world_.data() + 7 * LANES * joint;
            if (joint == 0) {
                for (int k = 0; k < LANES; ++k) {
                    for (int c = 0; c < 3; ++c) at[c][k] = root_positions[3 * of[k] + c];
                }
            } else {
                const float* above = world_.data() + 7 * LANES * bank_->skeleton_.parents[std::size_t(joint)];
                const auto& offset = bank_->skeleton_.offsets[std::size_t(joint)];
                const float x = float(offset[0]), y = float(offset[1]), z = float(offset[2]);
                for (int k = 0; k < LANES; ++k) {
                    const float px = above[k], py = above[LANES + k];
                    const float pz = above[2 * LANES + k], pw = above[3 * LANES + k];
                    const float tx = 2.0f * (py * z - pz * y), ty = 2.0f * (pz * x - px * z);
                    const float tz = 2.0f * (px * y - py * x);
                    at[0][k] = above[4 * LANES + k] + (x + pw * tx + (py * tz - pz * ty));
                    at[1][k] = above[5 * LANES + k] + (y + pw * ty + (pz * tx - px * tz));
                    at[2][k] = above[6 * LANES + k] + (z + pw * tz + (px * ty - py * tx));
                    const float qx = q[0][k], qy = q[1][k], qz = q[2][k], qw = q[3][k];
                    q[0][k] = pw * qx + px * qw + py * qz - pz * qy;
                    q[1][k] = pw * qy - px * qz + py * qw + pz * qx;
                    q[2][k] = pw * qz + px * qy - py * qx + pz * qw;
                    q[3][k] = pw * qw - px * qx - py * qy - pz * qz;
                }
            }
            std::memcpy(own, q, sizeof q);
            std::memcpy(own + 4 * LANES, at, sizeof at);
            for (int k = 0; k < LANES; ++k) {
                for (int c = 0; c < 3; ++c) positions[(of[k] * joints + joint) * 3 + c] = at[c][k];
            }
        }
    }
}

// --------------------------------------------------------------------------------------------------------- root motion

inline void Place::move(const RootMotion& motion) {
    const double sine = std::sin(heading), cosine = std::cos(heading);
    x += cosine * motion.x + sine * motion.z;
    y += motion.y;
    z += cosine * motion.z - sine * motion.x;
    heading += motion.turn;
}

/// Returns the root path at a real-valued frame: x, height of the ground, z and heading.
inline std::array<double, 4> Evaluator::path(int clip, double frame) const {
    const ClipEntry& entry = bank_->clip(clip);
    const detail::Between at = bank_->between(clip, frame, static_cast<double>(entry.row_count - 1));
    const double* here = bank_->paths_.data() + 4 * at.row;
    std::array<double, 4> out;
    for (std::size_t i = 0; i < 4; ++i) out[i] = here[i] + at.share * (here[i + 4] - here[i]);
    if (entry.mirrored) out[0] = -out[0], out[3] = -out[3];
    return out;
}

/// Returns the step along a path between two frames without a loop between them.
inline RootMotion Evaluator::walk(int clip, double from, double to) const {
    const std::array<double, 4> a = path(clip, from), b = path(clip, to);
    const double sine = std::sin(a[3]), cosine = std::cos(a[3]), x = b[0] - a[0], z = b[2] - a[2];
    RootMotion step;
    step.x = cosine * x - sine * z, step.y = b[1] - a[1], step.z = cosine * z + sine * x, step.turn = b[3] - a[3];
    return step;
}

inline RootMotion Evaluator::root_motion(int number, double time, double seconds) const {
    if (!exists(number)) return RootMotion();
    const ClipEntry& clip = bank_->clip(number);
    const double last = clip.last_frame(), from = std::min(std::max(time * clip.rate, 0.0), last);
    double to = from + std::max(seconds, 0.0) * clip.rate;
    RootMotion total;
    Place place;
    if (to > last && clip.loop > 0) {
        place.move(walk(number, from, last));
        const double phase = clip.last_phase - static_cast<double>(clip.loop);
        const double again = bank_->frame_at(number, phase, bank_->guess(number, phase));
        const RootMotion round = walk(number, again, last);
        total.cycles = clip.loop;
        for (to -= last - again; to > last && last - again > 0.0; to -= last - again) {
            place.move(round);
            total.cycles += clip.loop;
        }
        place.move(walk(number, again, to));
    } else {
        to = std::min(to, last);
        place.move(walk(number, from, to));
    }
    total.x = place.x, total.y = place.y, total.z = place.z, total.turn = place.heading;
    total.time = to / clip.rate;
    return total;
}

inline void Evaluator::put(const Place& place, int clip, double time, float* rotations, float* root_position) const {
    if (!exists(clip)) return;
    const std::array<double, 4> at = path(clip, time * bank_->clip(clip).rate);
    const double angle = place.heading - at[3], sine = std::sin(angle), cosine = std::cos(angle);
    const double x = root_position[0] - at[0], z = root_position[2] - at[2];
    root_position[0] = static_cast<float>(place.x + cosine * x + sine * z);
    root_position[1] = static_cast<float>(place.y + root_position[1] - at[1]);
    root_position[2] = static_cast<float>(place.z + cosine * z - sine * x);
    const detail::Quaternions<1> turn{{0.0}, {std::sin(0.5 * angle)}, {0.0}, {std::cos(0.5 * angle)}};
    const detail::Quaternions<1> root{{rotations[0]}, {rotations[1]}, {rotations[2]}, {rotations[3]}};
    double q[4];
    product(turn, root).get(0, q);
    for (int i = 0; i < 4; ++i) rotations[i] = static_cast<float>(q[i]);
}

}  // namespace motionsplice
