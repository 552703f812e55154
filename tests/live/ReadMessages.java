import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import lcm.lcm.LCMEncodable;
import stillframe_msgs.measurement_t;
import stillframe_msgs.run_info_t;

/** ReadMessages FOLDER: decodes every file there as the type it is called after, and writes it again. */
public class ReadMessages {
  public static void main(String[] arguments) throws Exception {
    Path[] files = Files.list(Path.of(arguments[0])).sorted().toArray(Path[]::new);
    for (Path file : files) {
      byte[] bytes = Files.readAllBytes(file);
      Class<?> type = Class.forName("stillframe_msgs." + file.getFileName());
      // As lcm-spy does: the fingerprint in the bytes is that of the class, or this throws.
      LCMEncodable message =
          (LCMEncodable) type.getConstructor(byte[].class).newInstance((Object) bytes);
      lcm.lcm.LCMDataOutputStream again = new lcm.lcm.LCMDataOutputStream();
      message.encode(again);
      if (!Arrays.equals(bytes, Arrays.copyOf(again.getBuffer(), again.size()))) {
        throw new Exception(file + ": what Java writes is not what it read");
      }
      if (message instanceof measurement_t) check((measurement_t) message);
      if (message instanceof run_info_t) check((run_info_t) message);
    }
    System.out.println(files.length + " types read");
  }

  static void check(measurement_t m) throws Exception {
    boolean same = m.run_id == 1234567890123456789L && m.seq == 25 && m.time_ns == 25000000L
        && m.n_legs == 2 && Arrays.equals(m.sigma, new double[] {1, 2})
        && Arrays.equals(m.applied_force, new double[] {3, 4})
        && Math.abs(m.floor_acceleration[0] - 2e-3) < 1e-17;  // the top of the sine
    if (!same) throw new Exception("measurement_t: other values than were written");
  }

  static void check(run_info_t m) throws Exception {
    if (!m.scene_name.equals("A sample") || !m.frame_names[1].equals("lens_x")) {
      throw new Exception("run_info_t: other values than were written");
    }
  }
}
