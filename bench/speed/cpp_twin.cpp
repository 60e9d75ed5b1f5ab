// The evaluator in C++ as a library that bench.speed.frames times: see sampler.h.
#include "sampler.h"

#include "../../clients/cpp/motionsplice.hpp"

namespace {

struct Twin {
    motionsplice::Bank bank;
    motionsplice::Evaluator evaluator;
    std::vector<motionsplice::Splice> splices;
    std::vector<double> times;

    explicit Twin(motionsplice::Bank opened) : bank(std::move(opened)), evaluator(bank) {}
};

}  // namespace

void* sampler_open(const char* bank) {
    motionsplice::Error error;
    motionsplice::Bank opened = motionsplice::Bank::open(bank, error);
    return error ? nullptr : new Twin(std::move(opened));
}

int sampler_evaluate(void* sampler, const sampler_request* requests, std::int32_t count, float* rotations,
                     float* root_positions) {
    Twin& twin = *static_cast<Twin*>(sampler);
    twin.splices.resize(count);
    twin.times.resize(count);
    for (std::int32_t k = 0; k < count; ++k) {
        twin.splices[k].locomotion = requests[k].locomotion;
        twin.splices[k].action = requests[k].action;
        twin.splices[k].start = requests[k].start;
        twin.times[k] = requests[k].time;
    }
    return twin.evaluator.poses(twin.splices.data(), twin.times.data(), count, rotations, root_positions) ? 1 : 0;
}

void sampler_close(void* sampler) { delete static_cast<Twin*>(sampler); }
