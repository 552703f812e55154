#include <fstream>
#include <iostream>

#include "stillframe_msgs/clock_exchange_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "tests/live/sample_messages.hpp"

// encoded_messages FOLDER: one message of each type as LCM puts it on the wire, in FOLDER/TYPE.
namespace {

using namespace stillframe::live;

template <class Message>
void write(const std::string& folder, const Message& message) {
  std::ofstream(folder + "/" + Message::getTypeName(), std::ios::binary)
      << sample::encoded(message);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "encoded_messages FOLDER\n";
    return 2;
  }
  const std::string folder = argv[1];
  constexpr std::int64_t run_id = 1234567890123456789;
  write(folder, sample::measurement(run_id, 25));
  write(folder, sample::command(run_id, 25));
  write(folder, sample::info(run_id));
  write(folder, sample::state(run_id, "plant", stillframe_msgs::run_state_t::FAILED, "a reason"));
  write(folder, sample::timing(run_id, "controller"));
  write(folder, sample::status(run_id));
  write(folder, sample::record(1000, 90, 7));
  write(folder, sample::records(run_id, {sample::record(1000, 90, 7), sample::record(2000, 1, 2)}));
  stillframe_msgs::control_request_t request{};
  request.run_id = run_id;
  request.nonce = 17;
  request.request = stillframe_msgs::control_request_t::STOP;
  write(folder, request);
  stillframe_msgs::loop_checkpoint_t checkpoint{};
  checkpoint.run_id = run_id;
  checkpoint.policy_text = "start: at_once\n";
  checkpoint.n = 3;
  checkpoint.memory = {0.1, -2e-300, 3};
  write(folder, checkpoint);
  stillframe_msgs::excitation_t excitation{};
  excitation.run_id = run_id;
  excitation.n_legs = 2;
  excitation.force = {0.5, -1e-300};
  write(folder, excitation);
  write(folder, stillframe_msgs::clock_exchange_t{
                    .asker = 11, .asked = 12, .asked_ns = -13, .heard_ns = 14, .answered_ns = 15});
}
