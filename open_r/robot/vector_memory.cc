#include "open_r/robot/vector_memory.h"

#include "open_r/library/system.h"

namespace seam::open_r {
namespace {

// Elements begin where any number may.
constexpr size_t kAlignment = 16;

size_t aligned(size_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

template <class Info>
void fill_info(const VectorLayout& layout, size_t frame_size, std::byte* memory, size_t i) {
  const size_t first = layout.header_size - layout.info_size;
  Info& info = *reinterpret_cast<Info*>(memory + first + i * layout.info_size);
  info.primitiveID = oprimitiveID_UNDEF;
  info.frameNumber = oframeINVALID_NUMBER;
  info.frameSize = frame_size;
  info.dataOffset = element_offset(layout, i);
  info.dataSize = layout.element_size;
}

}  // namespace

size_t element_offset(const VectorLayout& layout, size_t i) {
  const size_t more = layout.count > 1 ? (layout.count - 1) * layout.info_size : 0;
  return aligned(layout.header_size + more) + i * aligned(layout.element_size);
}

size_t layout_size(const VectorLayout& layout) {
  return element_offset(layout, layout.count);
}

void lay_out(const VectorLayout& layout, MemoryRegionID id, void* memory) {
  auto* header = static_cast<ODataVectorInfo*>(memory);
  header->memRegionID = id;
  header->totalSize = layout_size(layout);
  header->type = layout.type;
  header->infoOffset = layout.header_size - layout.info_size;
  header->infoSize = layout.info_size;
  header->maxNumData = layout.count;
  header->syncKey = ovrsynckeyUNDEF;
  auto* bytes = static_cast<std::byte*>(memory);
  for (size_t i = 0; i < layout.count; ++i) {
    if (layout.type == odataCOMMAND_VECTOR)
      fill_info<OCommandInfo>(layout, sizeof(OCommandValue), bytes, i);
    if (layout.type == odataSENSOR_FRAME_VECTOR)
      fill_info<OSensorFrameInfo>(layout, sizeof(OSensorValue), bytes, i);
    if (layout.type != odataSOUND_VECTOR) continue;
    fill_info<OSoundInfo>(layout, 0, bytes, i);
    static_cast<OSoundVectorData*>(memory)->info[i].maxDataSize = layout.element_size;
  }
}

VectorLayout command_layout(size_t count) {
  return {odataCOMMAND_VECTOR, sizeof(OCommandVectorData), sizeof(OCommandInfo), count,
          sizeof(OCommandData)};
}

VectorLayout sensor_layout(size_t count) {
  return {odataSENSOR_FRAME_VECTOR, sizeof(OSensorFrameVectorData), sizeof(OSensorFrameInfo), count,
          sizeof(OSensorFrameData)};
}

VectorLayout sound_layout(size_t count, size_t size) {
  return {odataSOUND_VECTOR, sizeof(OSoundVectorData), sizeof(OSoundInfo), count, size};
}

RCRegion* new_vector(const VectorLayout& layout) {
  auto* region = new RCRegion(layout_size(layout));
  lay_out(layout, region->MemID(), region->Base());
  return region;
}

void* VectorMemory::reserve(const VectorLayout& layout, MemoryRegionID id) {
  auto& piece = pieces_[id] = std::make_unique<std::byte[]>(layout_size(layout));
  lay_out(layout, id, piece.get());
  return piece.get();
}

void* VectorMemory::find(MemoryRegionID id) const {
  const auto found = pieces_.find(id);
  return found == pieces_.end() ? nullptr : found->second.get();
}

}  // namespace seam::open_r
