#include "ulog_reader.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "message_decoder.hpp"
#include "omniflight_files/files.hpp"
#include "ulog_records.hpp"

namespace omniflight::recording {
namespace {

using namespace ulog;

constexpr std::size_t kMaxUlogNotes = 200, kMaxTexts = 1000, kMaxDropouts = 1000, kMaxInformation = 1000,
                      kMaxParameters = 20000, kMaxChanges = 1000, kLongestValue = 300;
constexpr int kChain = 4;                             // so many records in a row are no coincidence
constexpr std::uint64_t kLongestPause = 600'000'000;  // us without any message; more is a wrong stamp
constexpr int kAgreeing = 20;  // wrong stamps that agree with each other are a new clock

/// What the messages of a format must look like.
struct Layout {
  std::uint64_t least = 0, most = 0;    // bytes
  std::optional<MessageDecoder> stamp;  // where the time stamp is not the first field
};

struct Subscribed {
  UlogSubscription topic;
  const Layout* layout = nullptr;  // none: its format is not defined, or has no time stamp
};

/// Time stamps that jump by more than kLongestPause are wrong, unless many agree.
class StampGuard {
 public:
  explicit StampGuard(std::uint64_t start_us) : last_(start_us) {}
  bool accept(std::uint64_t us) {
    if (near(us, last_) || (!any_ && last_ == 0)) {
      last_ = std::max(last_, us);
      any_ = true;
      agreeing_ = 0;
      return true;
    }
    agreeing_ = agreeing_ > 0 && near(us, candidate_) ? agreeing_ + 1 : 1;
    candidate_ = us;
    if (agreeing_ < kAgreeing) return false;
    last_ = us;
    agreeing_ = 0;
    any_ = true;
    ++jumps;
    return true;
  }
  std::uint64_t last() const { return last_; }
  std::uint64_t jumps = 0;

 private:
  static bool near(std::uint64_t a, std::uint64_t b) { return (a > b ? a - b : b - a) < kLongestPause; }
  std::uint64_t last_, candidate_ = 0;
  int agreeing_ = 0;
  bool any_ = false;
};

class UlogScanner {
 public:
  UlogScanner(std::string_view bytes, const UlogVisitor& visit, std::uint64_t start_us)
      : bytes_(bytes), visit_(visit), stamps_(start_us) {}

  UlogContent content;

  /// An error only when the file forbids to be read without knowing more.
  Status run(const std::string& file) {
    std::size_t at = ulog::kHeaderBytes;
    if (auto ok = read_flags(at, file); !ok) return ok;
    for (std::size_t section = 0; section <= appended_.size(); ++section) {
      const std::size_t end = section < appended_.size() ? appended_[section] : bytes_.size();
      read_section(at, end, section == appended_.size());
      at = end;
    }
    settle();
    return {};
  }

 private:
  Status read_flags(std::size_t& at, const std::string& file) {
    const auto record = record_at(bytes_, at, bytes_.size());
    if (!record || record->type != 'B' || record->body.size() < 40) return {};
    ByteCursor c(record->body);
    c.take(8);
    const auto incompatible = c.take(8);
    const bool more = static_cast<unsigned char>(incompatible[0]) > 1 ||
                      incompatible.substr(1).find_first_not_of('\0') != std::string_view::npos;
    if (more)
      return bad_input("is a ULog with extensions that this version does not know (incompat_flags)", file,
                       "Convert it with a newer tool (pyulog's ulog2csv), or the header is damaged");
    at += kRecordHead + record->body.size();
    if (incompatible[0] == 0) return {};
    std::size_t before = at;
    for (int i = 0; i < 3; ++i) {
      const auto offset = c.get<std::uint64_t>();
      if (offset == 0) continue;
      if (offset < before || offset > bytes_.size()) {
        note(Note::Kind::damage, "an appended section is told at byte " + std::to_string(offset) +
                                     ", which is not in the file (" + std::to_string(bytes_.size()) +
                                     " bytes)");
        continue;
      }
      before = static_cast<std::size_t>(offset);
      appended_.push_back(before);
    }
    return {};
  }

  void read_section(std::size_t at, std::size_t end, bool last) {
    while (at < end) {
      const auto record = record_at(bytes_, at, end);
      if (record && acceptable(*record)) {
        handle(*record);
        at += kRecordHead + record->body.size();
        continue;
      }
      // a record of an unknown type, or one whose content is damaged, between sound ones
      if (record && at + kRecordHead + record->body.size() < end &&
          chain(at + kRecordHead + record->body.size(), end)) {
        is_known(record->type) ? ++damaged_ : ++unknown_;
        at += kRecordHead + record->body.size();
        continue;
      }
      const std::size_t next = resynchronise(at + 1, end);
      if (next == end)
        note(Note::Kind::loss, std::string(last ? "the log ends" : "a section of the log ends") +
                                   " in the middle of a record: its last " + std::to_string(end - at) +
                                   " bytes were left out");
      else
        note(Note::Kind::damage, std::to_string(next - at) + " bytes at byte " + std::to_string(at) +
                                     " cannot be read and were skipped");
      at = next;
    }
  }

  std::size_t resynchronise(std::size_t at, std::size_t end) const {
    for (; at + kRecordHead <= end; ++at)
      if (is_known(bytes_[at + 2]) && chain(at, end)) return at;
    return end;
  }

  /// Whether kChain sound records follow each other, or fewer up to the end of the section.
  bool chain(std::size_t at, std::size_t end) const {
    for (int i = 0; i < kChain; ++i) {
      if (at == end) return i > 0;
      const auto record = record_at(bytes_, at, end);
      if (!record || !acceptable(*record)) return false;
      at += kRecordHead + record->body.size();
    }
    return true;
  }

  /// Whether a record is what it says. A message must have the size of its format.
  bool acceptable(const Record& r) const {
    if (!fits_its_type(r)) return false;
    if (r.type != 'D') return true;
    const auto found = subscribed_.find(ByteCursor(r.body).get<std::uint16_t>());
    if (found == subscribed_.end()) return false;
    const std::size_t size = r.body.size() - 2;
    const Layout* layout = found->second.layout;
    return !layout || (size >= layout->least && size <= layout->most);
  }

  void handle(const Record& r) {
    switch (r.type) {
      case 'F':
        define(r.body);
        break;
      case 'I':
        information(*key_value(r.body, 0));
        break;
      case 'P':
        parameter(*key_value(r.body, 0));
        break;
      case 'A':
        subscribe(r.body);
        break;
      case 'R':
        subscribed_.erase(ByteCursor(r.body).get<std::uint16_t>());
        break;
      case 'D':
        data(r.body);
        break;
      case 'L':
        text(r.body, 1);
        break;
      case 'C':
        text(r.body, 3);
        break;
      case 'O':
        dropout(ByteCursor(r.body).get<std::uint16_t>());
        break;
      default:
        break;  // B is read before; M, Q and S say nothing that we use
    }
  }

  void information(const KeyValue& kv) {
    if (content.information.size() >= kMaxInformation) return;
    std::string value;
    if (kv.type.substr(0, 4) == "char") {
      value = std::string(kv.value.substr(0, std::min(kv.value.find('\0'), kLongestValue)));
      for (char& c : value)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    } else if (const auto number = number_of(kv.type, kv.value)) {
      value = std::abs(*number) < 1e15 && *number == std::floor(*number)
                  ? std::to_string(static_cast<std::int64_t>(*number))
                  : std::to_string(*number);
    }
    content.information[std::string(kv.name)] = value;
  }

  void parameter(const KeyValue& kv) {
    const auto value = number_of(kv.type, kv.value);
    const std::string name(kv.name);
    if (!value || !std::isfinite(*value)) return;
    if (content.messages == 0) {
      if (content.parameters.size() < kMaxParameters) content.parameters[name] = *value;
    } else if (content.changes.size() < kMaxChanges) {
      content.changes.push_back({stamps_.last(), name, *value});
    }
  }

  /// The first definition of a format counts.
  void define(std::string_view text) {
    const std::string name(text.substr(0, text.find(':')));
    if (!content.types.contains(name) && !add_ulog_format(text, content.types)) ++damaged_;
  }

  /// Made once for a format, however many topics have it.
  const Layout* layout_of(const std::string& name) {
    if (const auto known = layouts_.find(name); known != layouts_.end()) return &known->second;
    const auto format = content.types.find(name);
    if (format == content.types.end()) return nullptr;
    auto decoder = MessageDecoder::create(name, content.types, {"timestamp"}, Encoding::ulog);
    if (!decoder || !decoder->has(0)) return nullptr;
    Layout& layout = layouts_[name];
    layout.least = std::max<std::uint64_t>(sizeof(std::uint64_t), decoder->least_bytes());
    layout.most = layout.least + decoder->padding();
    const FieldDefinition& first = format->second.front();
    if (first.name != "timestamp" || first.type != "uint64") layout.stamp = std::move(*decoder);
    return &layout;
  }

  void subscribe(std::string_view body) {
    ByteCursor c(body);
    Subscribed s;
    s.topic.instance = c.get<std::uint8_t>();
    s.topic.id = c.get<std::uint16_t>();
    s.topic.name = std::string(c.take(c.left()));
    s.layout = layout_of(s.topic.name);
    if (!s.layout)
      note(Note::Kind::damage, "topic " + files::shown(s.topic.name) +
                                   " has no usable format with a time stamp; its messages were left out");
    if (const auto before = subscribed_.find(s.topic.id);
        before != subscribed_.end() && before->second.topic.name != s.topic.name)
      note(Note::Kind::damage, "message id " + std::to_string(s.topic.id) + " is given to " +
                                   files::shown(s.topic.name) + " and to " +
                                   files::shown(before->second.topic.name));
    subscribed_[s.topic.id] = std::move(s);
  }

  void data(std::string_view body) {
    ByteCursor c(body);
    Subscribed& s = subscribed_.at(c.get<std::uint16_t>());
    const auto message = c.take(c.left());
    ++content.messages;
    if (!s.layout) return;
    std::uint64_t us = ByteCursor(message).get<std::uint64_t>();
    if (s.layout->stamp) {
      if (!s.layout->stamp->decode(message, numbers_) || numbers_[0].empty() || !(numbers_[0][0] >= 0)) {
        ++damaged_;
        return;
      }
      us = static_cast<std::uint64_t>(std::min(numbers_[0][0], 1e18));
    }
    if (!stamps_.accept(us)) us = stamps_.last();  // messages are logged in order
    visit_(content, s.topic, message, us);
  }

  void text(std::string_view body, std::size_t head) {
    ByteCursor c(body.substr(head));
    UlogText t;
    t.level = body[0];
    t.at_us = c.get<std::uint64_t>();
    t.text = std::string(c.take(c.left()));
    for (char& ch : t.text)
      if (static_cast<unsigned char>(ch) < 0x20 || ch == 0x7f) ch = ' ';
    ++content.text_count;
    if (content.texts.size() < kMaxTexts) content.texts.push_back(std::move(t));
  }

  void dropout(std::uint16_t ms) {
    ++content.dropout_count;
    content.dropouts_ms += ms;
    if (content.dropouts.size() < kMaxDropouts) content.dropouts.push_back({stamps_.last(), ms});
  }

  void settle() {
    const auto told = [&](std::uint64_t count, Note::Kind kind, const char* what) {
      if (count > 0) note(kind, std::to_string(count) + what, count);
    };
    told(damaged_, Note::Kind::damage, " records are damaged and were left out");
    told(stamps_.jumps, Note::Kind::damage, " times the clock of the log was set anew");
    told(unknown_, Note::Kind::ignored, " records are of a type that is not known");
    if (notes_left_out_ > 0)
      content.notes.push_back({Note::Kind::damage,
                               "and " + std::to_string(notes_left_out_) + " more such places",
                               notes_left_out_});
  }

  void note(Note::Kind kind, std::string what, std::uint64_t messages = 0) {
    if (content.notes.size() < kMaxUlogNotes)
      content.notes.push_back({kind, std::move(what), messages});
    else
      ++notes_left_out_;
  }

  std::string_view bytes_;
  const UlogVisitor& visit_;
  StampGuard stamps_;
  std::map<std::uint16_t, Subscribed> subscribed_;
  std::map<std::string, Layout> layouts_;
  std::vector<std::size_t> appended_;
  std::vector<std::vector<double>> numbers_;
  std::uint64_t damaged_ = 0, unknown_ = 0, notes_left_out_ = 0;
};

}  // namespace

Result<UlogContent> scan_ulog(std::string_view bytes, const std::string& file, const UlogVisitor& visit) {
  if (bytes.size() < ulog::kHeaderBytes || bytes.substr(0, ulog::kMagic.size()) != ulog::kMagic)
    return bad_input("holds no whole ULog header", file, "Copy the log from the card again");
  ByteCursor head(bytes.substr(ulog::kMagic.size()));
  const unsigned version = head.get<std::uint8_t>();
  const auto start_us = head.get<std::uint64_t>();
  UlogScanner scanner(bytes, visit, start_us);
  scanner.content.version = version;
  scanner.content.start_us = start_us;
  if (auto ok = scanner.run(file); !ok) return Failure(ok.error());
  return std::move(scanner.content);
}

}  // namespace omniflight::recording
