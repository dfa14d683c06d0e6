/* Empty: programs that include this for the robot's compiler need nothing of it in the simulator. */
