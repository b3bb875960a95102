// Waveforms through CXXRTL's own writer. Base class of the generated Dut, which has the design as `top`.

#include <cstdint>
#include <cstdio>
#include <cxxrtl/cxxrtl_vcd.h>

template <class Dut>
class Waves {
public:
    Waves() = default;
    Waves(const Waves &) = delete;
    ~Waves() {
        if (file_ != nullptr) std::fclose(file_);
    }

    void waves(const char *path) {
        file_ = std::fopen(path, "w");
        cxxrtl::debug_items items;
        static_cast<Dut *>(this)->top.debug_info(&items, nullptr, "dut ");
        writer_.timescale(1, "ns");
        // Line buffers would be thousands of variables that nobody reads.
        writer_.add_without_memories(items);
    }

    void sample(int64_t time) {
        if (file_ == nullptr) return;
        writer_.sample(uint64_t(time));
        std::fwrite(writer_.buffer.data(), 1, writer_.buffer.size(), file_);
        writer_.buffer.clear();
    }

private:
    std::FILE *file_ = nullptr;
    cxxrtl::vcd_writer writer_;
};
