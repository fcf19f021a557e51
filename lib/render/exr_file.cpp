
#include "render/exr_file.h"

#include "base/parallel.h"
#include "betamesh/error.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfRgba.h>

#include <cstring>
#include <list>

namespace betamesh {
namespace {

constexpr int kZipLevel = 1;  // three times as fast as the default 4; files are a few percent larger

class MemoryOut : public Imf::OStream {
public:
    MemoryOut() : Imf::OStream("memory") {}
    void write(const char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (at_ + count > bytes.size()) bytes.resize(at_ + count);
        std::memcpy(bytes.data() + at_, c, count);
        at_ += count;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t to) override { at_ = to; }

    std::string bytes;

private:
    std::size_t at_ = 0;
};

class MemoryIn : public Imf::IStream {
public:
    explicit MemoryIn(const std::string& bytes) : Imf::IStream("memory"), bytes_(bytes) {}
    bool read(char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (at_ > bytes_.size() || count > bytes_.size() - at_) throw std::runtime_error("the file is truncated");
        std::memcpy(c, bytes_.data() + at_, count);
        at_ += count;
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t to) override { at_ = to; }

private:
    const std::string& bytes_;
    std::size_t at_ = 0;
};

/// Calls visit(channel name, plane, whether it is stored as half) for every plane of floats.
template <typename AnyPicture, typename Visit>
void forPlanes(AnyPicture& picture, const Visit& visit) {
    visit("R", picture.red, true);
    visit("G", picture.green, true);
    visit("B", picture.blue, true);
    visit("A", picture.alpha, true);
    visit("shadow", picture.shadow, true);
    visit("Z", picture.depth, false);
    const char* const axes[] = {"X", "Y", "Z"};
    for (std::size_t i = 0; i < 3; ++i) visit(std::string("N.") + axes[i], picture.normal[i], true);
    for (std::size_t i = 0; i < 3; ++i) visit(std::string("P.") + axes[i], picture.position[i], false);
    visit("forward.u", picture.motion[0], false);
    visit("forward.v", picture.motion[1], false);
}

template <typename T>
Imf::Slice sliceOf(Imf::PixelType type, const T* rows, int width) {
    return {type, reinterpret_cast<char*>(const_cast<T*>(rows)), sizeof(T),
            sizeof(T) * static_cast<std::size_t>(width)};
}

}  // namespace

std::string encodeExr(const Picture& picture) {
    Imf::Header header(picture.width, picture.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = kZipLevel;
    Imf::FrameBuffer frame;
    std::list<std::vector<half>> halves;
    forPlanes(picture, [&](const std::string& name, const Plane& plane, bool as_half) {
        if (plane.empty()) return;
        header.channels().insert(name, Imf::Channel(as_half ? Imf::HALF : Imf::FLOAT));
        if (!as_half) {
            frame.insert(name, sliceOf(Imf::FLOAT, plane.data(), picture.width));
            return;
        }
        std::vector<half>& rounded = halves.emplace_back(plane.size());
        parallelFor(plane.size(), 65536, [&](std::size_t i) { rounded[i] = half(plane[i]); });
        frame.insert(name, sliceOf(Imf::HALF, rounded.data(), picture.width));
    });
    if (!picture.id.empty()) {
        header.channels().insert("id", Imf::Channel(Imf::UINT));
        frame.insert("id", sliceOf(Imf::UINT, picture.id.data(), picture.width));
    }
    MemoryOut out;
    {
        Imf::OutputFile file(out, header);
        file.setFrameBuffer(frame);
        file.writePixels(picture.height);
    }
    return std::move(out.bytes);
}

Picture decodeExr(const std::string& bytes, const std::string& file) {
    try {
        MemoryIn in(bytes);
        Imf::InputFile exr(in);
        const auto window = exr.header().dataWindow();
        const Imf::ChannelList& channels = exr.header().channels();
        Picture picture;
        picture.width = window.max.x - window.min.x + 1;
        picture.height = window.max.y - window.min.y + 1;
        Imf::FrameBuffer frame;
        const std::ptrdiff_t first = window.min.x + std::ptrdiff_t{window.min.y} * picture.width;
        forPlanes(picture, [&](const std::string& name, Plane& plane, bool) {
            if (channels.findChannel(name) == nullptr) return;
            plane.resize(picture.size());
            frame.insert(name, sliceOf(Imf::FLOAT, plane.data() - first, picture.width));
        });
        if (channels.findChannel("id") != nullptr) {
            picture.id.resize(picture.size());
            frame.insert("id", sliceOf(Imf::UINT, picture.id.data() - first, picture.width));
        }
        exr.setFrameBuffer(frame);
        exr.readPixels(window.min.y, window.max.y);
        return picture;
    } catch (const std::exception& error) {
        throw Error(file + ": cannot be read as an EXR picture: " + error.what());
    }
}

}  // namespace betamesh
