// Moves 64-bit words into and out of Verilator's ports. See harness.h.

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <verilated.h>

template <class Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
inline void put(Integer &port, const uint64_t *words) {
    port = Integer(words[0]);
}

template <class Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
inline void get(const Integer &port, uint64_t *words) {
    words[0] = port;
}

template <std::size_t Words>
inline void put(VlWide<Words> &port, const uint64_t *words) {
    for (std::size_t k = 0; k < Words; k++) port[k] = uint32_t(words[k / 2] >> (32 * (k % 2)));
}

template <std::size_t Words>
inline void get(const VlWide<Words> &port, uint64_t *words) {
    for (std::size_t k = 0; k < (Words + 1) / 2; k++) words[k] = 0;
    for (std::size_t k = 0; k < Words; k++) words[k / 2] |= uint64_t(port[k]) << (32 * (k % 2));
}

template <class Integer>
inline void put_bit(Integer &port, bool bit) {
    port = bit;
}

template <class Integer>
inline bool get_bit(const Integer &port) {
    return port != 0;
}
