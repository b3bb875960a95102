// Moves 64-bit words into and out of CXXRTL's values. See harness.h.

#include <cstdint>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

// CXXRTL forces the compiler to inline its helpers before it simplifies them. In one function as large as a
// flattened design clang then takes a minute where it takes seconds to simplify first; the code is no slower.
// g++ takes the same time either way, and its code is a tenth faster as CXXRTL wants it.
#ifdef __clang__
#define __always_inline__
#endif
#include <cxxrtl/cxxrtl.h>
#ifdef __clang__
#undef __always_inline__
#endif

template <size_t Bits>
inline void put(cxxrtl::value<Bits> &port, const uint64_t *words) {
    for (size_t k = 0; k < cxxrtl::value<Bits>::chunks; k++) port.data[k] = uint32_t(words[k / 2] >> (32 * (k % 2)));
}

template <size_t Bits>
inline void get(const cxxrtl::value<Bits> &port, uint64_t *words) {
    for (size_t k = 0; k < (Bits + 63) / 64; k++) words[k] = 0;
    for (size_t k = 0; k < cxxrtl::value<Bits>::chunks; k++) words[k / 2] |= uint64_t(port.data[k]) << (32 * (k % 2));
}

template <size_t Bits>
inline void get(const cxxrtl::wire<Bits> &port, uint64_t *words) {
    get(port.curr, words);
}

inline void put_bit(cxxrtl::value<1> &port, bool bit) { port.data[0] = bit; }
inline bool get_bit(const cxxrtl::value<1> &port) { return port.data[0] != 0; }
inline bool get_bit(const cxxrtl::wire<1> &port) { return port.curr.data[0] != 0; }
