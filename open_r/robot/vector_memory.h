// Memory of the data that travel between objects and the robot. The header, the blocks of
// information, then the elements lie in one piece.
#pragma once

#include <OPENR/ODataFormats.h>
#include <OPENR/RCRegion.h>

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

namespace seam::open_r {

// A piece that is laid out for `count` elements of one size, all zero.
struct VectorLayout {
  ODataType type = odataUNDEF;
  size_t header_size = 0;  // Of the structure with one block of information.
  size_t info_size = 0;
  size_t count = 0;
  size_t element_size = 0;
};

size_t layout_size(const VectorLayout& layout);
// Where element i begins.
size_t element_offset(const VectorLayout& layout, size_t i);
void lay_out(const VectorLayout& layout, MemoryRegionID id, void* memory);

VectorLayout command_layout(size_t count);
VectorLayout sensor_layout(size_t count);
VectorLayout sound_layout(size_t count, size_t size);

// A region with a vector in it, and one reference.
RCRegion* new_vector(const VectorLayout& layout);

// What programs reserved by OPENR::New...VectorData, by its number.
class VectorMemory {
 public:
  void* reserve(const VectorLayout& layout, MemoryRegionID id);
  void* find(MemoryRegionID id) const;
  bool release(MemoryRegionID id) { return pieces_.erase(id) == 1; }

 private:
  std::map<MemoryRegionID, std::unique_ptr<std::byte[]>> pieces_;
};

}  // namespace seam::open_r
