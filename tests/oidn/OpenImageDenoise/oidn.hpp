#pragma once
/// A stand-in for Open Image Denoise 2, for tests alone: the names, signatures and rules of its C++ API that denoise_oidn.cpp uses, from its
/// documentation (doc/api.md of releases 2.0 to 2.3). Its filter is the mean of 3 x 3 pixels. It is stricter than the library: values that
/// the documentation forbids are errors.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace oidn {

enum class Format { Undefined = 0, Float = 1, Float2, Float3, Float4, Half = 257, Half2, Half3, Half4 };
enum class DeviceType { Default = 0, CPU = 1, SYCL = 2, CUDA = 3, HIP = 4 };
enum class Error { None = 0, Unknown = 1, InvalidArgument = 2, InvalidOperation = 3, OutOfMemory = 4, UnsupportedHardware = 5, Cancelled = 6 };

namespace standin {

/// What a filter was executed with.
struct Execution {
    std::size_t width = 0, height = 0;
    bool hdr = false, cleanAux = false, setAffinity = true;
    std::map<std::string, std::vector<float>> images; ///< "color", "albedo", "normal": three values a pixel, row by row
};
struct World {
    std::vector<Execution> executions;
    bool hasDevice = true; ///< false: no device can be made
    Error error = Error::None;
    std::string message, told;
    void fail(Error code, const std::string &text) { // the first is kept until it is asked for
        if (error != Error::None) return;
        error = code;
        message = text;
    }
};
World &world();

struct Buffer {
    std::vector<unsigned char> bytes;
};
struct Picture {
    std::shared_ptr<Buffer> buffer;
    Format format = Format::Undefined;
    std::size_t width = 0, height = 0, offset = 0, pixelStride = 0, rowStride = 0;
};
struct Device {
    bool committed = false;
    std::map<std::string, bool> parameters;
};
struct Filter {
    std::shared_ptr<Device> device;
    std::string type;
    std::map<std::string, Picture> images;
    std::map<std::string, bool> parameters;
    bool committed = false;
};
void setImage(Filter *filter, const std::string &name, const Picture &picture);
void commit(Filter *filter);
void execute(Filter *filter);

} // namespace standin

class BufferRef {
  public:
    BufferRef() = default;
    explicit BufferRef(std::shared_ptr<standin::Buffer> handle) : handle_(std::move(handle)) {}
    explicit operator bool() const { return handle_ != nullptr; }
    [[nodiscard]] std::size_t getSize() const { return handle_ ? handle_->bytes.size() : 0; }
    void read(std::size_t byteOffset, std::size_t byteSize, void *to) {
        if (!fits(byteOffset, byteSize)) return;
        std::memcpy(to, handle_->bytes.data() + byteOffset, byteSize);
    }
    void write(std::size_t byteOffset, std::size_t byteSize, const void *from) {
        if (!fits(byteOffset, byteSize)) return;
        std::memcpy(handle_->bytes.data() + byteOffset, from, byteSize);
    }

  private:
    friend class FilterRef;
    std::shared_ptr<standin::Buffer> handle_;
    [[nodiscard]] bool fits(std::size_t byteOffset, std::size_t byteSize) const {
        const bool good = handle_ && byteOffset + byteSize <= handle_->bytes.size();
        if (!good) standin::world().fail(Error::InvalidArgument, "buffer region is out of range");
        return good;
    }
};

class FilterRef {
  public:
    FilterRef() = default;
    explicit FilterRef(std::shared_ptr<standin::Filter> handle) : handle_(std::move(handle)) {}
    explicit operator bool() const { return handle_ != nullptr; }
    void setImage(const char *name, const BufferRef &buffer, Format format, std::size_t width, std::size_t height, std::size_t byteOffset = 0,
                  std::size_t bytePixelStride = 0, std::size_t byteRowStride = 0) {
        standin::setImage(handle_.get(), name, {buffer.handle_, format, width, height, byteOffset, bytePixelStride, byteRowStride});
    }
    void set(const char *name, bool value) {
        if (!handle_) return standin::world().fail(Error::InvalidArgument, "invalid handle");
        if (std::string(name) != "hdr" && std::string(name) != "srgb" && std::string(name) != "cleanAux")
            return standin::world().fail(Error::InvalidArgument, std::string("unknown filter parameter: ") + name);
        handle_->parameters[name] = value;
        handle_->committed = false;
    }
    void commit() { standin::commit(handle_.get()); }
    void execute() { standin::execute(handle_.get()); }

  private:
    std::shared_ptr<standin::Filter> handle_;
};

class DeviceRef {
  public:
    DeviceRef() = default;
    explicit DeviceRef(std::shared_ptr<standin::Device> handle) : handle_(std::move(handle)) {}
    explicit operator bool() const { return handle_ != nullptr; }
    void set(const char *name, bool value) {
        if (!handle_ || handle_->committed) return standin::world().fail(Error::InvalidOperation, "device parameters after commit");
        handle_->parameters[name] = value;
    }
    /// Once.
    void commit() {
        if (!handle_) return standin::world().fail(Error::InvalidArgument, "invalid handle");
        if (handle_->committed) return standin::world().fail(Error::InvalidOperation, "device can be committed only once");
        handle_->committed = true;
    }
    /// Of this thread, and clears it; works without a device too.
    Error getError(const char *&message) {
        standin::World &w = standin::world();
        w.told = w.message;
        message = w.told.c_str();
        return std::exchange(w.error, Error::None);
    }
    [[nodiscard]] BufferRef newBuffer(std::size_t byteSize) const {
        if (!isReady()) return {};
        auto buffer = std::make_shared<standin::Buffer>();
        buffer->bytes.assign(byteSize, 0xff); // NaN until somebody writes
        return BufferRef(std::move(buffer));
    }
    [[nodiscard]] FilterRef newFilter(const char *type) const {
        if (!isReady()) return {};
        if (std::string(type) != "RT" && std::string(type) != "RTLightmap") {
            standin::world().fail(Error::InvalidArgument, std::string("unknown filter type: ") + type);
            return {};
        }
        auto filter = std::make_shared<standin::Filter>();
        filter->device = handle_;
        filter->type = type;
        return FilterRef(std::move(filter));
    }

  private:
    std::shared_ptr<standin::Device> handle_;
    [[nodiscard]] bool isReady() const {
        if (!handle_) standin::world().fail(Error::InvalidArgument, "invalid handle");
        if (handle_ && !handle_->committed) standin::world().fail(Error::InvalidOperation, "changes to the device are not committed");
        return handle_ && handle_->committed;
    }
};

inline DeviceRef newDevice(DeviceType type = DeviceType::Default) {
    const bool known = type == DeviceType::Default || type == DeviceType::CPU;
    if (known && standin::world().hasDevice) return DeviceRef(std::make_shared<standin::Device>());
    standin::world().fail(Error::UnsupportedHardware, "unsupported device type: CPU");
    return {};
}

} // namespace oidn
