// The evaluator in C++ as a shared library, for bench/speed/cpp_twin.py.
#include "../../clients/cpp/motionsplice.hpp"

struct Twin {
    motionsplice::Bank bank;
    motionsplice::Evaluator evaluator;

    explicit Twin(motionsplice::Bank opened) : bank(std::move(opened)), evaluator(bank) {}
};

extern "C" {

Twin* open_bank(const char* folder) {
    motionsplice::Error error;
    motionsplice::Bank bank = motionsplice::Bank::open(folder, error);
    return error ? nullptr : new Twin(std::move(bank));
}

void close_bank(Twin* twin) { delete twin; }

bool evaluate(Twin* twin, const motionsplice::Splice* splices, const double* times, int count, float* rotations,
              float* root_positions) {
    return !twin->evaluator.poses(splices, times, count, rotations, root_positions);
}
}
