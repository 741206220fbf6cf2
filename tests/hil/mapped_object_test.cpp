#include "sextant/hil/mapped_object.hpp"

#include <atomic>
#include <cstdint>
#include <optional>
#include <system_error>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sextant {
namespace {

/// Counts the objects that have begun.
struct Counted {
  static inline int begun = 0;

  Counted() noexcept { ++begun; }

  std::atomic<std::uint64_t> number{7};
};

class MappedObjectTest : public testing::Test {
 protected:
  MappedObjectTest() {
    EXPECT_EQ(ftruncate(file, sizeof(Counted)), 0);
    Counted::begun = 0;
  }
  ~MappedObjectTest() override { close(file); }

  int file{memfd_create("sextant_test", MFD_CLOEXEC)};
};

TEST_F(MappedObjectTest, EachMappingBeginsItsObjectOnceAndKeepsWhatTheFileHolds) {
  const MappedObject<Counted> first{file};
  EXPECT_EQ(Counted::begun, 1);
  EXPECT_EQ(first.get().number.load(), 0U) << "the file's value, not the constructor's";
  first.get().number.store(5);
  const MappedObject<Counted> second{file};
  EXPECT_EQ(Counted::begun, 2);
  EXPECT_EQ(second.get().number.load(), 5U);
  EXPECT_EQ(first.get().number.load(), 5U) << "another mapping writes nothing";
}

TEST_F(MappedObjectTest, BothMappingsAreOneMemory) {
  const MappedObject<Counted> first{file};
  const MappedObject<Counted> second{file};
  for (std::uint64_t n = 1; n < 4; ++n) {
    first.get().number.fetch_add(n);
    EXPECT_EQ(second.get().number.load(), first.get().number.load());
    second.get().number.fetch_add(n);
    EXPECT_EQ(first.get().number.load(), second.get().number.load());
  }
}

TEST_F(MappedObjectTest, ARenewedObjectHasItsFirstValueForEveryone) {
  MappedObject<Counted> first{file};
  const MappedObject<Counted> second{file};
  first.get().number.store(5);
  first.renew();
  EXPECT_EQ(Counted::begun, 3);
  EXPECT_EQ(second.get().number.load(), 7U);
}

TEST_F(MappedObjectTest, TheObjectOutlivesItsMapping) {
  std::optional<MappedObject<Counted>> first{file};
  first->get().number.store(5);
  first.reset();
  EXPECT_EQ(MappedObject<Counted>{file}.get().number.load(), 5U);
}

TEST_F(MappedObjectTest, WhatCannotBeMappedIsAnError) {
  EXPECT_THROW(MappedObject<Counted>{-1}, std::system_error);
}

}  // namespace
}  // namespace sextant
