// Evaluates what stdin asks for: the program of tests/clients/test_cpp.py.
//
//     evaluate BANK < REQUESTS
//
//     poses COUNT RATE   then COUNT lines: locomotion action hands start method posture cycles time
//                        answers: COUNT lines of root position, rotations and world positions, and the number of
//                        allocations. RATE above 0 gives each character a memory that lasts from command to command.
//     walk CLIP TIME SECONDS STEPS
//                        answers: STEPS lines of x y z turn time cycles, then of the root's position and rotation
//     find NAME          answers: the number of a clip, its first and last phase, and its name; or -1
//
// Whatever fails is answered by "error", its kind and its message.
#include "../motionsplice.hpp"

#include <cstdlib>
#include <iostream>
#include <new>

namespace ms = motionsplice;

static long allocations = 0;

// Not inlined, because GCC then warns that `free` does not go with `new`.
__attribute__((noinline)) void* operator new(std::size_t size) {
    ++allocations;
    void* memory = std::malloc(size > 0 ? size : 1);
    if (memory == nullptr) std::abort();
    return memory;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

static void show(const ms::Error& error) {
    const char* kinds[] = {"none", "bank", "time_range", "settings"};
    std::cout << "error " << kinds[static_cast<int>(error.kind)] << ' ' << error.message() << '\n';
}

static void show(const float* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) std::cout << numbers[i] << ' ';
}

static void poses(const ms::Bank& bank, ms::Evaluator& evaluator, std::vector<ms::Memory>& memories) {
    std::size_t count = 0;
    double rate = 0.0;
    std::cin >> count >> rate;
    std::vector<ms::Splice> splices(count);
    std::vector<double> times(count);
    for (std::size_t k = 0; k < count; ++k) {
        ms::Splice& splice = splices[k];
        int method = 0, posture = 0;
        std::string start, time;  // may be nan, which streams do not read
        std::cin >> splice.locomotion >> splice.action >> splice.hands >> start >> method >> posture;
        std::cin >> splice.cycles >> time;
        splice.start = std::strtod(start.c_str(), nullptr);
        times[k] = std::strtod(time.c_str(), nullptr);
        splice.method = static_cast<ms::Method>(method);
        splice.posture = static_cast<ms::Posture>(posture);
    }
    while (memories.size() < count) memories.push_back(ms::Memory::begin(rate));
    const auto joints = static_cast<std::size_t>(bank.joint_count());
    std::vector<float> rotations(4 * joints * count), roots(3 * count), positions(3 * joints * count);
    ms::Memory* remembered = rate > 0.0 ? memories.data() : nullptr;
    const long before = allocations;
    const int number = static_cast<int>(count);
    const ms::Error error =
        evaluator.poses(splices.data(), times.data(), number, rotations.data(), roots.data(), remembered);
    if (error) return show(error);
    evaluator.world_positions(rotations.data(), roots.data(), number, positions.data());
    const long allocated = allocations - before;
    for (std::size_t k = 0; k < count; ++k) {
        show(roots.data() + 3 * k, 3);
        show(rotations.data() + 4 * joints * k, 4 * joints);
        show(positions.data() + 3 * joints * k, 3 * joints);
        std::cout << allocated << '\n';
    }
}

static void walk(const ms::Bank& bank, ms::Evaluator& evaluator) {
    ms::Splice splice;
    double time = 0.0, seconds = 0.0;
    int steps = 0;
    std::cin >> splice.locomotion >> time >> seconds >> steps;
    ms::Place place;
    std::vector<float> rotations(4 * static_cast<std::size_t>(bank.joint_count())), root(3);
    for (int step = 0; step < steps; ++step) {
        const ms::RootMotion motion = evaluator.root_motion(splice.locomotion, time, seconds);
        place.move(motion);
        time = motion.time;
        if (const ms::Error error = evaluator.pose(splice, time, rotations.data(), root.data())) return show(error);
        evaluator.put(place, splice.locomotion, time, rotations.data(), root.data());
        std::cout << motion.x << ' ' << motion.y << ' ' << motion.z << ' ' << motion.turn << ' ' << motion.time << ' '
                  << motion.cycles << ' ';
        show(root.data(), 3);
        show(rotations.data(), 4);
        std::cout << '\n';
    }
}

static void find(const ms::Bank& bank) {
    std::string name;
    std::getline(std::cin >> std::ws, name);
    const int number = bank.find(name);
    std::cout << number;
    if (number != ms::NOT_FOUND) {
        const ms::ClipEntry& clip = bank.clip(number);
        std::cout << ' ' << clip.first_phase << ' ' << clip.last_phase << ' ' << clip.name;
    }
    std::cout << '\n';
}

int main(int count, char** arguments) {
    if (count != 2) return 2;
    std::cout.precision(9);
    ms::Error error;
    const ms::Bank bank = ms::Bank::open(arguments[1], error);
    if (error) return show(error), 0;
    ms::Evaluator evaluator(bank);
    std::vector<ms::Memory> memories;
    for (std::string command; std::cin >> command;) {
        if (command == "poses") poses(bank, evaluator, memories);
        if (command == "walk") walk(bank, evaluator);
        if (command == "find") find(bank);
    }
    return 0;
}
