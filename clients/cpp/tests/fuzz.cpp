// Opens a bank made of fuzzed bytes and evaluates it: `make fuzz-cpp`.
//
// The input is the files of a bank, the manifest's body first, then the tables in the order of docs/bank.md, each after
// its size (4 bytes, little-endian). Digests are not checked. Without libFuzzer (-DREPLAY), the program reads inputs
// from the files that its arguments name, and prints one line for each.
#define FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
#include "../motionsplice.hpp"

namespace ms = motionsplice;

// Returns a sum of all results, so that nothing is optimised away.
static float evaluate(const ms::Bank& bank) {
    constexpr int COUNT = 19;  // more than a block
    ms::Evaluator evaluator(bank);
    const auto joints = static_cast<std::size_t>(bank.joint_count());
    const int images = bank.has_mirror_images() ? 2 : 1, clips = images * static_cast<int>(bank.clips().size());
    std::vector<float> rotations(4 * joints * COUNT), roots(3 * COUNT), positions(3 * joints * COUNT);
    std::vector<ms::Memory> memories(COUNT, ms::Memory::begin(30.0));
    std::vector<ms::Splice> splices(COUNT);
    std::vector<double> times(COUNT);
    for (int k = 0; k < COUNT; ++k) {
        ms::Splice& splice = splices[static_cast<std::size_t>(k)];
        splice.locomotion = k % clips;
        splice.action = k % 5 == 4 ? ms::NOTHING : k * 7 % clips;
        splice.method = static_cast<ms::Method>(k % 4 == 3 ? 1 : 2);
        splice.posture = static_cast<ms::Posture>(k / 2 % 4);
        splice.cycles = k % 3 == 2 ? (std::int64_t(1) << 40) - k : 0;
        const double end = bank.clip(splice.locomotion).end();
        times[static_cast<std::size_t>(k)] = end * k / COUNT;
        for (const ms::HandsEntry& one : bank.hands()) {
            const int upper = splice.action == ms::NOTHING ? splice.locomotion : splice.action;
            if (bank.find(one.body) == upper || bank.find(one.body + "~mirror") == upper) splice.hands = bank.find_hands(one.name);
        }
    }
    const ms::Error error =
        evaluator.poses(splices.data(), times.data(), COUNT, rotations.data(), roots.data(), memories.data());
    if (error) return static_cast<float>(error.message().size());
    evaluator.world_positions(rotations.data(), roots.data(), COUNT, positions.data());
    float sum = 0.0f;
    for (const float number : positions) sum += number;
    for (int clip = 0; clip < std::min(clips, 20); ++clip) {
        const double end = bank.clip(clip).end();
        const ms::RootMotion motion = evaluator.root_motion(clip, 0.9 * end, 0.2 * end);
        ms::Place place;
        place.move(motion);
        evaluator.put(place, clip, motion.time, rotations.data(), roots.data());
        sum += roots[0];
    }
    return sum;
}

static std::string run(const unsigned char* data, std::size_t size) {
    const unsigned char* end = data + size;
    const auto files = [&](const std::string& name, std::vector<unsigned char>& bytes) {
        if (end - data < 4) return false;
        std::size_t length = 0;
        for (int i = 0; i < 4; ++i) length |= std::size_t(*data++) << (8 * i);
        length = std::min(length, static_cast<std::size_t>(end - data));
        if (name != "manifest.msgpack") {
            bytes.assign(data, data + length);
        } else {
            const char outer[] =
                "\x84\xa6" "format\xb1motionsplice bank\xa7version\x07\xa6" "digest\xa0\xa4" "body\xc6";
            bytes.assign(outer, outer + sizeof outer - 1);
            for (int i = 3; i >= 0; --i) bytes.push_back(static_cast<unsigned char>(length >> (8 * i)));
            bytes.insert(bytes.end(), data, data + length);
        }
        data += length;
        return true;
    };
    ms::Error error;
    const ms::Bank bank = ms::Bank::open(files, "fuzzed", error);
    return error ? error.message() : "opened " + std::to_string(evaluate(bank));
}

#ifdef REPLAY
int main(int count, char** names) {
    for (int i = 1; i < count; ++i) {
        std::vector<unsigned char> bytes;
        if (!ms::detail::read_file(names[i], bytes)) return 2;
        std::puts(run(bytes.data(), bytes.size()).c_str());
    }
    return 0;
}
#else
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    run(data, size);
    return 0;
}
#endif
