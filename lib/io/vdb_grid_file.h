// A .vdb file whose grids are read one at a time, and whose damage is noticed.

#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <map>
#include <memory>
#include <string>

namespace betamesh {

/// The grids of a file. Unlike openvdb::io::File it fails at the end of the file: OpenVDB does not check its streams
/// while it reads a grid, and goes on with the last size it has read until memory runs out.
class GridFile : public openvdb::io::Archive {
public:
    using Descriptor = openvdb::io::GridDescriptor;

    /// errors  a file that is missing, is not of OpenVDB, or ends too early; std::ios_base::failure: cannot be read
    explicit GridFile(const std::string& path);

    /// Sorted by name.
    const std::multimap<std::string, Descriptor>& descriptors() const { return descriptors_; }

    /// errors  as the constructor
    openvdb::GridBase::Ptr read(const Descriptor& descriptor);

private:
    openvdb::GridBase::Ptr readTree(const Descriptor& descriptor);
    openvdb::GridBase::Ptr readHere(const Descriptor& descriptor);

    openvdb::io::StreamMetadata::Ptr stream_state_ = std::make_shared<openvdb::io::StreamMetadata>();
    std::ifstream stream_;  // refers to stream_state_
    std::multimap<std::string, Descriptor> descriptors_;
    std::map<std::string, openvdb::GridBase::Ptr>
        loaded_;  // by unique name; only of files that cannot be read in parts
};

}  // namespace betamesh
