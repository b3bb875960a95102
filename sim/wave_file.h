// A file for waves, which keeps in mind what went wrong: a full disk is to be told, and not to end the process.

#pragma once

#include <cerrno>
#include <cstdio>

class WaveFile {
public:
    WaveFile() = default;
    WaveFile(const WaveFile &) = delete;
    ~WaveFile() { close(); }

    bool open(const char *path) {
        file_ = std::fopen(path, "w");
        if (file_ == nullptr) error_ = errno;
        return file_ != nullptr;
    }

    void write(const char *data, size_t size) {
        if (error_ == 0 && std::fwrite(data, 1, size, file_) != size) error_ = errno;
    }

    void close() {
        if (file_ != nullptr && std::fclose(file_) != 0 && error_ == 0) error_ = errno;
        file_ = nullptr;
    }

    // errno of the first failure, or 0.
    int error() const { return error_; }

private:
    std::FILE *file_ = nullptr;
    int error_ = 0;
};
