// Lists of a fixed size, regions and pointers that count their references.
#include <OPENR/OList.h>
#include <OPENR/OShmPtr.h>
#include <gtest/gtest.h>

#include "open_r/library/system.h"

namespace seam::open_r {
namespace {

TEST(List, HoldsNoMoreThanItsSize) {
  OList<int, 3> list;
  EXPECT_EQ(list.PopFront(), otlUNDERFLOW);
  EXPECT_EQ(list.PushBack(2), otlSUCCESS);
  EXPECT_EQ(list.PushFront(1), otlSUCCESS);
  EXPECT_EQ(list.PushBack(3), otlSUCCESS);
  EXPECT_EQ(list.PushBack(4), otlOVERFLOW);
  EXPECT_EQ(list.GetSize(), 3);
  EXPECT_EQ(list.GetMaxSize(), 3);
  EXPECT_EQ(list.Front(), 1);
  EXPECT_EQ(list.Back(), 3);
}

TEST(List, IteratorsInsertAndErase) {
  OList<int, 4> list;
  for (int i = 0; i < 3; ++i) list.PushBack(i);
  OList<int, 4>::Iterator second = list.Begin();
  ++second;
  EXPECT_EQ(list.Insert(second, 7), otlSUCCESS);
  EXPECT_EQ(list.Erase(second), otlSUCCESS);
  EXPECT_EQ(list.Erase(list.End()), otlFAIL);
  std::vector<int> items;
  for (auto at = list.Begin(); at != list.End(); ++at) items.push_back(*at);
  EXPECT_EQ(items, (std::vector<int>{0, 7, 2}));
  list.Clear();
  EXPECT_EQ(list.GetSize(), 0);
}

TEST(Regions, PointersCountAndCopyBeforeTheyWrite) {
  System system;
  auto* region = new RCRegion(2 * sizeof(int));
  OShmPtr<int> pointer(region);
  EXPECT_EQ(region->NumberOfReference(), 2);
  pointer[0] = 5;  // Another holds the region: a copy is written.
  EXPECT_EQ(region->NumberOfReference(), 1);
  EXPECT_EQ(reinterpret_cast<int*>(region->Base())[0], 0);
  EXPECT_EQ(static_cast<int>(pointer[0]), 5);
  EXPECT_EQ(pointer.NumOfElement(), 2u);
  {
    const OShmPtr<int> more(pointer);
    EXPECT_EQ(pointer.RCRPtr()->NumberOfReference(), 2);
  }
  EXPECT_EQ(pointer.RCRPtr()->NumberOfReference(), 1);
  region->RemoveReference();
}

// Memory that objects name to each other by its number.
TEST(Regions, SharedOnesAreGivenBackByNumber) {
  System system;
  MemoryRegionID id = 0;
  void* base = nullptr;
  ASSERT_EQ(NewSharedMemoryRegion(16, MEMPROTINFO_RW, &id, &base), sSUCCESS);
  static_cast<char*>(base)[15] = 1;
  EXPECT_EQ(DeleteSharedMemoryRegion(id), sSUCCESS);
  EXPECT_EQ(DeleteSharedMemoryRegion(id), sINVALIDARG);
}

}  // namespace
}  // namespace seam::open_r
