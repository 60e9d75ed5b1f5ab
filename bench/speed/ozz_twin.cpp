// Plain replacement of the upper body by ozz-animation (0.15 or later), as a library that bench.speed.frames times: see
// sampler.h. docs/performance.md has the command that compiles it. Nothing of ozz-animation is part of this project.
//
// Both clips are sampled whole by SamplingJob, each by a context that its character keeps. The upper body's rotations
// are chosen while four joints at a time are turned into quaternions of single joints.
#include "sampler.h"

#include <algorithm>
#include <memory>

#include "../../clients/cpp/motionsplice.hpp"
#include "ozz/animation/offline/animation_builder.h"
#include "ozz/animation/offline/raw_animation.h"
#include "ozz/animation/runtime/animation.h"
#include "ozz/animation/runtime/sampling_job.h"
#include "ozz/base/maths/soa_transform.h"

namespace {

using ozz::animation::Animation;
using ozz::animation::SamplingJob;
using ozz::animation::offline::RawAnimation;
namespace math = ozz::math;

constexpr std::size_t LANES = 4;
constexpr float SEEK_INTERVAL = 0.25f;  // seconds between frames to which random times jump: the fastest of 0 to 10 s

template <class Number>
math::Float3 point(const Number* xyz) {
    return math::Float3(static_cast<float>(xyz[0]), static_cast<float>(xyz[1]), static_cast<float>(xyz[2]));
}

/// Builds the animation of a clip and its seam, with the bank's frames as keys. Returns null if that fails.
ozz::unique_ptr<Animation> built(const motionsplice::Bank& bank, motionsplice::Evaluator& evaluator, int number) {
    const motionsplice::ClipEntry& clip = bank.clip(number);
    const motionsplice::Skeleton& rig = bank.skeleton();
    std::vector<float> rotations(4 * rig.names.size());
    float root[3];
    motionsplice::Splice alone;
    alone.locomotion = number;
    RawAnimation raw;
    raw.duration = static_cast<float>(clip.end());
    raw.tracks.resize(rig.names.size());
    for (std::size_t joint = 1; joint < raw.tracks.size(); ++joint) {
        raw.tracks[joint].translations.push_back({0.0f, point(rig.offsets[joint].data())});
    }
    for (double frame = 0.0; frame <= clip.last_frame(); ++frame) {
        if (evaluator.pose(alone, frame / clip.rate, rotations.data(), root)) return nullptr;
        const auto time = static_cast<float>(frame / clip.rate);
        raw.tracks[0].translations.push_back({time, point(root)});
        for (std::size_t joint = 0; joint < raw.tracks.size(); ++joint) {
            const float* q = &rotations[4 * joint];
            raw.tracks[joint].rotations.push_back({time, math::Quaternion(q[0], q[1], q[2], q[3])});
        }
    }
    ozz::animation::offline::AnimationBuilder builder;
    builder.iframe_interval = SEEK_INTERVAL;
    return builder(raw);
}

/// Samples a clip by a context and into a pose of its own.
struct Sampled {
    SamplingJob::Context context;
    std::vector<math::SoaTransform>* pose;

    Sampled(int joints, std::vector<math::SoaTransform>& pose) : context(joints), pose(&pose) {}

    bool run(const Animation& animation, double seconds) {
        SamplingJob job;
        job.animation = &animation;
        job.context = &context;
        job.ratio = static_cast<float>(seconds) / animation.duration();
        job.output = ozz::make_span(*pose);
        return job.Run();
    }
};

struct Character {
    Sampled locomotion, action;
};

struct Naive {
    std::size_t joints;
    std::vector<ozz::unique_ptr<Animation>> clips;
    std::vector<int> is_upper;                     // of each joint, -1 or 0; as many as there are lanes
    std::vector<math::SoaTransform> lower, upper;  // one character's poses
    std::vector<std::unique_ptr<Character>> characters;

    explicit Naive(const motionsplice::Bank& bank) : joints(std::size_t(bank.joint_count())) {
        is_upper.resize(LANES * ((joints + LANES - 1) / LANES));
        for (std::size_t joint = 0; joint < joints; ++joint) {
            const std::int64_t parent = bank.skeleton().parents[joint];
            const bool under_upper = parent >= 0 && is_upper[std::size_t(parent)];
            is_upper[joint] = static_cast<int>(joint) == bank.pelvis() || under_upper ? -1 : 0;
        }
        lower.resize(is_upper.size() / LANES);
        upper.resize(is_upper.size() / LANES);
    }

    void reserve(std::size_t count) {
        const int tracks = static_cast<int>(joints);
        while (characters.size() < count) {
            characters.emplace_back(new Character{{tracks, lower}, {tracks, upper}});
        }
    }

    void write(float* rotations, float* root_position) const {
        for (std::size_t four = 0; four < lower.size(); ++four) {
            const math::SoaQuaternion &below = lower[four].rotation, &above = upper[four].rotation;
            const math::SimdInt4 mask = math::simd_int4::LoadPtrU(&is_upper[LANES * four]);
            const math::SimdFloat4 planes[4] = {
                math::Select(mask, above.x, below.x), math::Select(mask, above.y, below.y),
                math::Select(mask, above.z, below.z), math::Select(mask, above.w, below.w)};
            math::SimdFloat4 single[4];
            math::Transpose4x4(planes, single);
            const std::size_t count = std::min(LANES, joints - LANES * four);
            for (std::size_t i = 0; i < count; ++i) math::StorePtrU(single[i], rotations + 4 * (LANES * four + i));
        }
        const math::SoaFloat3& place = lower[0].translation;
        root_position[0] = math::GetX(place.x);
        root_position[1] = math::GetX(place.y);
        root_position[2] = math::GetX(place.z);
    }
};

}  // namespace

void* sampler_open(const char* folder) {
    motionsplice::Error error;
    const motionsplice::Bank bank = motionsplice::Bank::open(folder, error);
    if (error) return nullptr;
    motionsplice::Evaluator evaluator(bank);
    auto naive = std::make_unique<Naive>(bank);
    for (std::size_t clip = 0; clip < bank.clips().size(); ++clip) {
        naive->clips.push_back(built(bank, evaluator, static_cast<int>(clip)));
        if (!naive->clips.back()) return nullptr;
    }
    return naive.release();
}

int sampler_evaluate(void* sampler, const sampler_request* requests, std::int32_t count, float* rotations,
                     float* root_positions) {
    Naive& naive = *static_cast<Naive*>(sampler);
    naive.reserve(std::size_t(count));
    for (std::int32_t k = 0; k < count; ++k) {
        const sampler_request& asked = requests[k];
        Character& character = *naive.characters[std::size_t(k)];
        if (!character.locomotion.run(*naive.clips[std::size_t(asked.locomotion)], asked.time)) return 1;
        if (!character.action.run(*naive.clips[std::size_t(asked.action)], asked.action_time)) return 1;
        naive.write(rotations + 4 * naive.joints * std::size_t(k), root_positions + 3 * k);
    }
    return 0;
}

void sampler_close(void* sampler) { delete static_cast<Naive*>(sampler); }
