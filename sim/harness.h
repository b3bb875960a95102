// The clock loop of a compiled simulation. Included after the generated description of the ports:
//
//   struct Dut             reset(bool), level(port, value), settle(), advance(), waves(path), sample(time),
//                          finish(): closes the waves, errno if they could not be written
//   struct Input0, ...     words, payload(Dut &, const uint64_t *), valid(Dut &, bool), ready(Dut &)
//   struct Output0, ...    words, always_ready, payload(Dut &, uint64_t *), valid(Dut &), ready(Dut &, bool)
//   using Inputs, Outputs  std::tuple of the above
//
// settle() evaluates the design up to just before the rising edge, advance() passes the edge.
// Which engine evaluates it is none of this file's business; the rules are those of sim/engine.py.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

#ifdef _WIN32
#define EXPORT extern "C" __declspec(dllexport)
#else
#define EXPORT extern "C" __attribute__((visibility("default")))
#endif

namespace harness {

// These four structures are mirrored in sim/native.py.
struct InputSpec {
    const uint64_t *payloads;
    int64_t count;
    const uint8_t *stalls;
    int64_t period;
    int64_t *accepted;
};

struct OutputSpec {
    const uint8_t *stalls;
    int64_t period;
};

struct LevelChange {
    int64_t beat;
    int64_t port;
    uint64_t value;
};

struct Spec {
    const InputSpec *inputs;
    const OutputSpec *outputs;
    const LevelChange *changes;
    int64_t change_count;
    int64_t reset_after;
    int64_t quiet;
    int64_t max_clocks;
    const char *waves;
    int64_t wave_clocks;
};

enum Outcome : int { RUNNING = 0, FINISHED = 1, HANG = 2, WITHDRAWN = 3, CHANGED = 4 };

constexpr int64_t HALF_PERIOD = 5;  // ns, of the clock in waveforms

template <class Port>
struct Source {
    InputSpec spec{};
    int64_t next = 0;
    int64_t phase = 0;
    bool held = false;
};

template <class Port>
struct Sink {
    OutputSpec spec{};
    int64_t phase = 0;
    bool ready = false;
    bool waiting = false;
    uint64_t held[Port::words] = {};
    std::vector<uint64_t> payloads;
    std::vector<int64_t> clocks;
};

template <class>
struct States;

template <class... Inputs, class... Outputs>
struct States<std::pair<std::tuple<Inputs...>, std::tuple<Outputs...>>> {
    std::tuple<Source<Inputs>...> sources;
    std::tuple<Sink<Outputs>...> sinks;
    static constexpr auto input_indices = std::index_sequence_for<Inputs...>{};
    static constexpr auto output_indices = std::index_sequence_for<Outputs...>{};
};

class Simulation {
public:
    explicit Simulation(const Spec &spec) : spec_(spec) {
        std::copy(spec.changes, spec.changes + spec.change_count, std::back_inserter(changes_));
        attach(states_.input_indices, states_.output_indices);
        reset_due_ = spec.reset_after == 0;
        dut_.reset(false);
        apply_levels(0);
        if (spec.waves != nullptr) dut_.waves(spec.waves);
    }

    int run(int64_t clocks) { return run(clocks, states_.input_indices, states_.output_indices); }

    int finish_waves() { return dut_.finish(); }

    int64_t clock() const { return clock_; }
    int64_t remaining() const { return remaining_; }
    int64_t broken_stream() const { return broken_stream_; }
    const std::vector<uint64_t> &broken_words() const { return broken_words_; }

    // Calls f with sink number `stream`.
    template <class F>
    void with_sink(int64_t stream, F f) {
        with_sink(stream, f, states_.output_indices);
    }

private:
    Spec spec_;
    Dut dut_;
    States<std::pair<Inputs, Outputs>> states_;
    std::vector<LevelChange> changes_;
    size_t next_change_ = 0;
    int64_t clock_ = 0;
    int64_t idle_ = 0;
    int64_t remaining_ = 0;
    bool reset_due_ = false;
    int outcome_ = RUNNING;
    int64_t broken_stream_ = -1;
    std::vector<uint64_t> broken_words_;

    template <size_t... I, size_t... O>
    void attach(std::index_sequence<I...>, std::index_sequence<O...>) {
        ((std::get<I>(states_.sources).spec = spec_.inputs[I]), ...);
        ((std::get<O>(states_.sinks).spec = spec_.outputs[O]), ...);
        remaining_ = (int64_t(0) + ... + spec_.inputs[I].count);
    }

    template <class F, size_t... O>
    void with_sink(int64_t stream, F &f, std::index_sequence<O...>) {
        ((stream == int64_t(O) ? f(std::get<O>(states_.sinks)) : void()), ...);
    }

    void apply_levels(int64_t beat) {
        for (; next_change_ < changes_.size() && changes_[next_change_].beat <= beat; next_change_++)
            dut_.level(changes_[next_change_].port, changes_[next_change_].value);
    }

    static bool paused(const uint8_t *stalls, int64_t period, int64_t &phase) {
        bool pause = stalls[phase];
        phase = phase + 1 == period ? 0 : phase + 1;
        return pause;
    }

    template <size_t N>
    void drive() {
        using Port = std::tuple_element_t<N, Inputs>;
        auto &source = std::get<N>(states_.sources);
        bool pause = paused(source.spec.stalls, source.spec.period, source.phase);
        if (reset_due_) {
            if (source.held) {
                source.held = false;
                source.next++;
                remaining_--;
            }
        } else if (!source.held && !pause && source.next < source.spec.count) {
            source.held = true;
            Port::payload(dut_, source.spec.payloads + source.next * Port::words);
            if (N == 0) apply_levels(source.next);
        }
        Port::valid(dut_, source.held);
    }

    template <size_t N>
    void offer() {
        using Port = std::tuple_element_t<N, Outputs>;
        auto &sink = std::get<N>(states_.sinks);
        bool pause = paused(sink.spec.stalls, sink.spec.period, sink.phase);
        sink.ready = Port::always_ready || (!pause && !reset_due_);
        Port::ready(dut_, sink.ready);
    }

    template <size_t N>
    void accept() {
        using Port = std::tuple_element_t<N, Inputs>;
        auto &source = std::get<N>(states_.sources);
        if (source.held && Port::ready(dut_)) {
            source.spec.accepted[source.next++] = clock_;
            source.held = false;
            remaining_--;
        }
    }

    template <size_t N>
    bool take() {
        using Port = std::tuple_element_t<N, Outputs>;
        auto &sink = std::get<N>(states_.sinks);
        if (!Port::valid(dut_)) {
            if (sink.waiting) fail<Port>(WITHDRAWN, N, sink.held, sink.held);
            return false;
        }
        uint64_t words[Port::words];
        Port::payload(dut_, words);
        if (sink.waiting && std::memcmp(words, sink.held, sizeof words) != 0)
            fail<Port>(CHANGED, N, sink.held, words);
        sink.waiting = !sink.ready;
        if (sink.waiting) {
            std::memcpy(sink.held, words, sizeof words);
        } else {
            sink.payloads.insert(sink.payloads.end(), words, words + Port::words);
            sink.clocks.push_back(clock_);
        }
        return true;
    }

    template <class Port>
    void fail(Outcome outcome, int64_t stream, const uint64_t *held, const uint64_t *seen) {
        if (outcome_ != RUNNING) return;
        outcome_ = outcome;
        broken_stream_ = stream;
        broken_words_.assign(held, held + Port::words);
        broken_words_.insert(broken_words_.end(), seen, seen + Port::words);
    }

    void sample(int64_t time) {
        if (spec_.waves != nullptr && clock_ < spec_.wave_clocks) dut_.sample(time);
    }

    // Everything between two rising edges, then the edge.
    template <size_t... I, size_t... O>
    void step(std::index_sequence<I...>, std::index_sequence<O...>) {
        (drive<I>(), ...);
        (offer<O>(), ...);
        if (__builtin_expect(reset_due_, 0)) dut_.reset(true);
        dut_.settle();
        sample(2 * HALF_PERIOD * clock_);
        bool active = false;
        if (__builtin_expect(reset_due_, 0)) {
            ((std::get<O>(states_.sinks).waiting = false), ...);
            reset_due_ = false;
            spec_.reset_after = -1;
            dut_.advance();
            dut_.reset(false);
            idle_ = 0;
        } else {
            (accept<I>(), ...);
            ((active |= take<O>()), ...);
            dut_.advance();
            reset_due_ = (false || ... || (I == 0 && std::get<I>(states_.sources).next == spec_.reset_after));
            idle_ = remaining_ != 0 || active || reset_due_ ? 0 : idle_ + 1;
        }
        sample(2 * HALF_PERIOD * clock_ + HALF_PERIOD);
        clock_++;
    }

    template <size_t... I, size_t... O>
    int run(int64_t clocks, std::index_sequence<I...> inputs, std::index_sequence<O...> outputs) {
        int64_t end = std::min(clock_ + clocks, spec_.max_clocks);
        while (clock_ < end && outcome_ == RUNNING) {
            step(inputs, outputs);
            if (__builtin_expect(idle_ >= spec_.quiet, 0) && outcome_ == RUNNING) outcome_ = FINISHED;
        }
        if (outcome_ == RUNNING && clock_ >= spec_.max_clocks) outcome_ = HANG;
        return outcome_;
    }
};

}  // namespace harness

EXPORT void *sim_open(const harness::Spec *spec) { return new harness::Simulation(*spec); }

EXPORT void sim_close(void *sim) { delete static_cast<harness::Simulation *>(sim); }

// Runs up to `clocks` clocks; returns a harness::Outcome.
EXPORT int sim_run(void *sim, int64_t clocks) { return static_cast<harness::Simulation *>(sim)->run(clocks); }

EXPORT int64_t sim_clock(void *sim) { return static_cast<harness::Simulation *>(sim)->clock(); }

// Input beats neither accepted nor lost yet.
EXPORT int64_t sim_remaining(void *sim) { return static_cast<harness::Simulation *>(sim)->remaining(); }

EXPORT int64_t sim_delivered(void *sim, int64_t stream) {
    int64_t count = 0;
    static_cast<harness::Simulation *>(sim)->with_sink(stream, [&](auto &sink) { count = int64_t(sink.clocks.size()); });
    return count;
}

// Copies everything an output stream has delivered; the caller has made room for sim_delivered() beats.
EXPORT void sim_copy(void *sim, int64_t stream, uint64_t *payloads, int64_t *clocks) {
    static_cast<harness::Simulation *>(sim)->with_sink(stream, [&](auto &sink) {
        std::copy(sink.payloads.begin(), sink.payloads.end(), payloads);
        std::copy(sink.clocks.begin(), sink.clocks.end(), clocks);
    });
}

// After the last clock: 0, or why waves could not be written, as errno says it.
EXPORT int sim_finish_waves(void *sim) { return static_cast<harness::Simulation *>(sim)->finish_waves(); }

// After WITHDRAWN or CHANGED: the stream, and its words before and after.
EXPORT int64_t sim_broken(void *sim, uint64_t *words) {
    auto &simulation = *static_cast<harness::Simulation *>(sim);
    std::copy(simulation.broken_words().begin(), simulation.broken_words().end(), words);
    return simulation.broken_stream();
}
