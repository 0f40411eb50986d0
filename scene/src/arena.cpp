#include "maille/scene/arena.hpp"

#include <atomic>

namespace maille {

/// The counts of an arena. Whoever has something in it keeps it: the arena, those within, and charges.
class Arena::Ledger {
public:
  Ledger(std::int64_t limit, Ledger* around) : limit_(limit), around_(around) {
    if (around_ != nullptr)
      around_->keep();
  }

  /// @return false, and nothing is counted, where a limit would be passed that counts
  bool take(std::int64_t bytes, bool may_refuse) {
    const std::int64_t now = present_ += bytes;
    if ((may_refuse && now > limit_) || (around_ != nullptr && !around_->take(bytes, may_refuse))) {
      present_ -= bytes;
      return false;
    }
    for (std::int64_t most = peak_; now > most && !peak_.compare_exchange_weak(most, now);) {
    }
    return true;
  }
  void give_back(std::int64_t bytes) {
    for (Ledger* at = this; at != nullptr; at = at->around_)
      at->present_ -= bytes;
  }
  void keep() { ++keepers_; }
  void let_go() {
    if (--keepers_ > 0)
      return;
    Ledger* const around = around_;
    delete this;
    if (around != nullptr)
      around->let_go();
  }
  std::int64_t present() const { return present_; }
  std::int64_t peak() const { return peak_; }

private:
  std::atomic<std::int64_t> present_{0}, peak_{0}, keepers_{1};
  const std::int64_t limit_;
  Ledger* const around_;
};

namespace {

thread_local Arena::Ledger* open_ledger = nullptr;
thread_local bool may_refuse = false;

/// Where what is charged before memory begins.
struct Head {
  Arena::Ledger* ledger;
  std::int64_t bytes;
};

Arena::Ledger* take_from_open(std::size_t bytes) {
  if (open_ledger == nullptr)
    return nullptr;
  if (!open_ledger->take(static_cast<std::int64_t>(bytes), may_refuse))
    throw ArenaIsFull();
  open_ledger->keep();
  return open_ledger;
}

void give_back(Arena::Ledger* ledger, std::int64_t bytes) {
  if (ledger == nullptr)
    return;
  ledger->give_back(bytes);
  ledger->let_go();
}

} // namespace

Arena::Arena(std::int64_t limit) : ledger_(new Ledger(limit, open_ledger)) {}

Arena::~Arena() {
  ledger_->let_go();
}

std::int64_t Arena::present() const {
  return ledger_->present();
}

std::int64_t Arena::peak() const {
  return ledger_->peak();
}

Arena::Open::Open(Ledger* ledger, bool refuses)
    : before_(std::exchange(open_ledger, ledger)), could_refuse_(std::exchange(may_refuse, refuses)) {}

Arena::Open::~Open() {
  open_ledger = before_;
  may_refuse = could_refuse_;
}

Arena::Ledger* Arena::open_on_this_thread() {
  return open_ledger;
}

Charge::Charge(std::size_t bytes) : ledger_(take_from_open(bytes)), bytes_(bytes) {}

Charge::~Charge() {
  give_back(ledger_, static_cast<std::int64_t>(bytes_));
}

void* allocate_charged(std::size_t bytes, std::size_t alignment) {
  static_assert(sizeof(Head) <= 16);
  const std::size_t all = bytes + alignment;
  const Head head{take_from_open(all), static_cast<std::int64_t>(all)};
  void* const begin = ::operator new (all, std::align_val_t{alignment}, std::nothrow);
  if (begin == nullptr) {
    give_back(head.ledger, head.bytes);
    throw std::bad_alloc();
  }
  return reinterpret_cast<char*>(new (begin) Head(head)) + alignment;
}

void release_charged(void* memory, std::size_t alignment) noexcept {
  char* const begin = static_cast<char*>(memory) - alignment;
  const Head head = *reinterpret_cast<Head*>(begin);
  ::operator delete (begin, std::align_val_t{alignment});
  give_back(head.ledger, head.bytes);
}

} // namespace maille
