// Waveforms through CXXRTL's own writer. Base class of the generated Dut, which has the design as `top`.

#include <cstdint>
#include <cxxrtl/cxxrtl_vcd.h>

#include "wave_file.h"

template <class Dut>
class Waves {
public:
    Waves() = default;
    Waves(const Waves &) = delete;

    void waves(const char *path) {
        file_.open(path);
        cxxrtl::debug_items items;
        static_cast<Dut *>(this)->top.debug_info(&items, nullptr, "dut ");
        writer_.timescale(1, "ns");
        // Line buffers would be thousands of variables that nobody reads.
        writer_.add_without_memories(items);
    }

    void sample(int64_t time) {
        writer_.sample(uint64_t(time));
        file_.write(writer_.buffer.data(), writer_.buffer.size());
        writer_.buffer.clear();
    }

    int finish() {
        file_.close();
        return file_.error();
    }

private:
    WaveFile file_;
    cxxrtl::vcd_writer writer_;
};
