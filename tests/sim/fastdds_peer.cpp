// A node as ROS 2 has it by default, on eProsima Fast DDS: it knows names, types and the order of
// fields of ROS 2's definitions, and nothing of crgsim's idl. It drives a unit of `crgsim serve
// --dds --lockstep` with the topics of dds_test.cpp and prints what it hears.
//   fastdds_peer DOMAIN COMMANDS
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr, eprosima::fastcdr::FastBuffer;
using Bytes = std::vector<char>;

/// Messages as bytes, with the name of a type.
class Raw : public fast::TopicDataType {
 public:
  explicit Raw(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 100'000;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<const Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    const char* const begin = reinterpret_cast<const char*>(payload->data);
    static_cast<Bytes*>(data)->assign(begin, begin + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

class Node {
 public:
  explicit Node(unsigned domain) {
    // As ROS_LOCALHOST_ONLY=1 has it.
    const auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    loopback->interfaceWhiteList.emplace_back("127.0.0.1");
    fast::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(loopback);
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
  }

  fast::DataReader* reader(const std::string& name, const std::string& type) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 10;
    qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return subscriber_->create_datareader(topic(name, type), qos);
  }
  fast::DataWriter* writer(const std::string& name, const std::string& type) {
    fast::DataWriterQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 10;
    return publisher_->create_datawriter(topic(name, type), qos);
  }

 private:
  fast::Topic* topic(const std::string& name, const std::string& type) {
    fast::TypeSupport(new Raw(type)).register_type(participant_);
    return participant_->create_topic("rt/" + name, type, fast::TOPIC_QOS_DEFAULT);
  }
  fast::DomainParticipant* participant_;
  fast::Subscriber* subscriber_;
  fast::Publisher* publisher_;
};

/// Takes a message apart, field by field.
class Message {
 public:
  explicit Message(Bytes bytes)
      : bytes_(std::move(bytes)),
        buffer_(bytes_.data(), bytes_.size()),
        cdr_(buffer_, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) {
    cdr_.read_encapsulation();
  }
  template <class Value>
  Value next() {
    Value value{};
    cdr_ >> value;
    return value;
  }
  double time_s() { return next<std::int32_t>() + 1e-9 * next<std::uint32_t>(); }
  void skip_doubles(int count) {
    for (int k = 0; k < count; ++k) next<double>();
  }

 private:
  Bytes bytes_;
  FastBuffer buffer_;
  Cdr cdr_;
};

/// The next message, waited for at most so long; empty where none came.
Bytes take(fast::DataReader* reader, double wait_s) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
  Bytes bytes;
  fast::SampleInfo info;
  do {
    if (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK && info.valid_data)
      return bytes;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (std::chrono::steady_clock::now() < until);
  return {};
}

/// kerbstone_msgs/CarCommand.
Bytes command(std::uint32_t sequence, double steering_rad, bool ends) {
  Bytes bytes(1000);
  FastBuffer buffer(bytes.data(), bytes.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << std::int32_t{0} << std::uint32_t{0} << sequence << steering_rad << 0.0;
  cdr << std::array<double, 4>{} << std::int32_t{1} << 0.0;
  const std::uint32_t none = 0;
  cdr << none << none << ends << false << false << none << none << none;
  cdr << std::string() << std::string();
  bytes.resize(cdr.getSerializedDataLength());
  return bytes;
}

/// Says a command until its step is told: a reader that is found at the same time misses the first.
double answered(fast::DataWriter* writer, fast::DataReader* step, std::uint32_t sequence) {
  for (int tries = 0; tries < 20; ++tries) {
    Bytes said = command(sequence, 0.25 * sequence, false);
    writer->write(&said);
    for (Bytes bytes = take(step, 1.0); !bytes.empty(); bytes = take(step, 1.0)) {
      Message told(std::move(bytes));
      const double time_s = told.time_s();
      if (told.next<std::uint32_t>() == sequence) return time_s;
    }
  }
  return std::nan("");
}

void hear(fast::DataReader* imu, fast::DataReader* fix, fast::DataReader* odom,
          fast::DataReader* twist) {
  if (Bytes bytes = take(imu, 1.0); !bytes.empty()) {
    Message message(std::move(bytes));
    const double time_s = message.time_s();
    const auto frame = message.next<std::string>();
    message.skip_doubles(4 + 9 + 2);
    const auto z_radps = message.next<double>();
    message.skip_doubles(8);
    const auto z_variance = message.next<double>(), x_mps2 = message.next<double>();
    message.skip_doubles(1);
    std::printf(" imu %g %s %g %g %g %g", time_s, frame.c_str(), z_radps, z_variance, x_mps2,
                message.next<double>());
  }
  if (Bytes bytes = take(fix, 1.0); !bytes.empty()) {
    Message message(std::move(bytes));
    const double time_s = message.time_s();
    const auto frame = message.next<std::string>();
    message.next<std::int8_t>();
    message.next<std::uint16_t>();
    const auto latitude_deg = message.next<double>(), longitude_deg = message.next<double>();
    message.skip_doubles(1);
    std::printf(" fix %g %s %g %g %g", time_s, frame.c_str(), latitude_deg, longitude_deg,
                message.next<double>());
  }
  if (Bytes bytes = take(odom, 1.0); !bytes.empty()) {
    Message message(std::move(bytes));
    message.time_s();
    message.next<std::string>();
    message.next<std::string>();
    const auto x_m = message.next<double>(), y_m = message.next<double>();
    message.skip_doubles(1 + 2);
    const auto quaternion_z = message.next<double>();
    message.skip_doubles(1 + 36);
    std::printf(" odom %g %g %g %g", x_m, y_m, quaternion_z, message.next<double>());
  }
  if (Bytes bytes = take(twist, 1.0); !bytes.empty()) {
    Message message(std::move(bytes));
    message.time_s();
    const auto frame = message.next<std::string>();
    const auto x_mps = message.next<double>();
    message.skip_doubles(4);
    std::printf(" twist %s %g %g", frame.c_str(), x_mps, message.next<double>());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Node node(static_cast<unsigned>(std::atoi(argv[1])));
  const auto commands = static_cast<std::uint32_t>(std::atoi(argv[2]));
  auto* const imu = node.reader("imu", "sensor_msgs::msg::dds_::Imu_");
  auto* const fix = node.reader("fix", "sensor_msgs::msg::dds_::NavSatFix_");
  auto* const odom = node.reader("car/odom", "nav_msgs::msg::dds_::Odometry_");
  auto* const twist = node.reader("twist", "geometry_msgs::msg::dds_::TwistWithCovarianceStamped_");
  auto* const clock = node.reader("clock", "rosgraph_msgs::msg::dds_::Clock_");
  auto* const step = node.reader("crgsim/step", "kerbstone_msgs::msg::dds_::Step_");
  auto* const writer = node.writer("crgsim/command", "kerbstone_msgs::msg::dds_::CarCommand_");
  const auto matched = [&] {
    for (fast::DataReader* const reader : {imu, fix, odom, twist, clock, step}) {
      fast::SubscriptionMatchedStatus status;
      reader->get_subscription_matched_status(status);
      if (status.current_count == 0) return false;
    }
    fast::PublicationMatchedStatus status;
    writer->get_publication_matched_status(status);
    return status.current_count > 0;
  };
  for (int tries = 0; tries < 1000 && !matched(); ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (!matched()) return std::puts("not matched"), 1;
  for (std::uint32_t k = 1; k <= commands; ++k) {
    const double time_s = answered(writer, step, k);
    Bytes time = take(clock, 1.0);
    if (std::isnan(time_s) || time.empty()) return std::puts("nothing came"), 1;
    std::printf("step %u %g clock %g", k, time_s, Message(std::move(time)).time_s());
    hear(imu, fix, odom, twist);
    std::printf("\n");
  }
  Bytes last = command(commands + 1, 0.0, true);
  writer->write(&last);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  return 0;
}
