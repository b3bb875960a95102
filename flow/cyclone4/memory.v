// M9K blocks found by memory_libmap become altsyncram cells.
//
// Only rden and wren, which memory_libmap knows, control the input side of the ports: clocken0 is bypassed there.
// So it is free for the output registers, where the refinement of the netlist puts flip-flops into them: then it is
// their enable, on both ports, and a write in the same clock takes place whatever it is.

module \$__CYCLONE4_M9K_ (PORT_W_CLK, PORT_W_ADDR, PORT_W_WR_DATA, PORT_W_WR_EN,
                          PORT_R_CLK, PORT_R_ADDR, PORT_R_RD_DATA, PORT_R_RD_EN);
  parameter WIDTH = 9;
  parameter PORT_W_WR_EN_WIDTH = 1;
  input PORT_W_CLK;
  input [12:0] PORT_W_ADDR;
  input [WIDTH-1:0] PORT_W_WR_DATA;
  input PORT_W_WR_EN;
  input PORT_R_CLK;
  input [12:0] PORT_R_ADDR;
  output [WIDTH-1:0] PORT_R_RD_DATA;
  input PORT_R_RD_EN;

  localparam UNUSED = WIDTH == 1 ? 0 : WIDTH == 2 ? 1 : WIDTH == 4 ? 2 : WIDTH == 9 ? 3 : WIDTH == 18 ? 4 : 5;
  localparam BITS = 13 - UNUSED;

  altsyncram #(
    .operation_mode("DUAL_PORT"),
    .intended_device_family("Cyclone IV GX"),
    .ram_block_type("M9K"),
    .width_a(WIDTH), .widthad_a(BITS), .numwords_a(1 << BITS),
    .width_b(WIDTH), .widthad_b(BITS), .numwords_b(1 << BITS),
    .address_reg_b("CLOCK0"), .rdcontrol_reg_b("CLOCK0"), .outdata_reg_b("UNREGISTERED"),
    .read_during_write_mode_mixed_ports("OLD_DATA"),
    .clock_enable_input_a("BYPASS"), .clock_enable_output_a("BYPASS"),
    .clock_enable_input_b("BYPASS"), .clock_enable_output_b("BYPASS"),
    .power_up_uninitialized("FALSE")
  ) _TECHMAP_REPLACE_ (
    .clock0(PORT_W_CLK), .clocken0(1'b1),
    .address_a(PORT_W_ADDR[12:UNUSED]), .data_a(PORT_W_WR_DATA), .wren_a(PORT_W_WR_EN), .rden_a(1'b0),
    .address_b(PORT_R_ADDR[12:UNUSED]), .rden_b(PORT_R_RD_EN), .q_b(PORT_R_RD_DATA)
  );
endmodule

module \$__CYCLONE4_M9K_TABLE_ (PORT_R_CLK, PORT_R_ADDR, PORT_R_RD_DATA, PORT_R_RD_EN);
  parameter WIDTH = 9;
  parameter [9215:0] INIT = 0;
  input PORT_R_CLK;
  input [12:0] PORT_R_ADDR;
  output [WIDTH-1:0] PORT_R_RD_DATA;
  input PORT_R_RD_EN;

  localparam UNUSED = WIDTH == 1 ? 0 : WIDTH == 2 ? 1 : WIDTH == 4 ? 2 : WIDTH == 9 ? 3 : WIDTH == 18 ? 4 : 5;
  localparam BITS = 13 - UNUSED;

  altsyncram #(
    .operation_mode("DUAL_PORT"),
    .intended_device_family("Cyclone IV GX"),
    .ram_block_type("M9K"),
    .width_a(WIDTH), .widthad_a(BITS), .numwords_a(1 << BITS),
    .width_b(WIDTH), .widthad_b(BITS), .numwords_b(1 << BITS),
    .address_reg_b("CLOCK0"), .rdcontrol_reg_b("CLOCK0"), .outdata_reg_b("UNREGISTERED"),
    .read_during_write_mode_mixed_ports("OLD_DATA"),
    .clock_enable_input_a("BYPASS"), .clock_enable_output_a("BYPASS"),
    .clock_enable_input_b("BYPASS"), .clock_enable_output_b("BYPASS"),
    .power_up_uninitialized("FALSE"),
    .contents(INIT)
  ) _TECHMAP_REPLACE_ (
    .clock0(PORT_R_CLK), .clocken0(1'b1),
    .address_a({BITS{1'b0}}), .data_a({WIDTH{1'b0}}), .wren_a(1'b0), .rden_a(1'b0),
    .address_b(PORT_R_ADDR[12:UNUSED]), .rden_b(PORT_R_RD_EN), .q_b(PORT_R_RD_DATA)
  );
endmodule

module \$__CYCLONE4_M9K_TABLE_TWICE_ (PORT_A_CLK, PORT_A_ADDR, PORT_A_RD_DATA, PORT_A_RD_EN,
                                      PORT_B_CLK, PORT_B_ADDR, PORT_B_RD_DATA, PORT_B_RD_EN);
  parameter WIDTH = 9;
  parameter [9215:0] INIT = 0;
  input PORT_A_CLK, PORT_B_CLK;
  input [12:0] PORT_A_ADDR, PORT_B_ADDR;
  output [WIDTH-1:0] PORT_A_RD_DATA, PORT_B_RD_DATA;
  input PORT_A_RD_EN, PORT_B_RD_EN;

  localparam UNUSED = WIDTH == 1 ? 0 : WIDTH == 2 ? 1 : WIDTH == 4 ? 2 : WIDTH == 9 ? 3 : 4;
  localparam BITS = 13 - UNUSED;

  altsyncram #(
    .operation_mode("BIDIR_DUAL_PORT"),
    .intended_device_family("Cyclone IV GX"),
    .ram_block_type("M9K"),
    .width_a(WIDTH), .widthad_a(BITS), .numwords_a(1 << BITS), .outdata_reg_a("UNREGISTERED"),
    .width_b(WIDTH), .widthad_b(BITS), .numwords_b(1 << BITS),
    .address_reg_b("CLOCK0"), .rdcontrol_reg_b("CLOCK0"), .outdata_reg_b("UNREGISTERED"),
    .indata_reg_b("CLOCK0"), .wrcontrol_wraddress_reg_b("CLOCK0"),
    .read_during_write_mode_mixed_ports("OLD_DATA"),
    .clock_enable_input_a("BYPASS"), .clock_enable_output_a("BYPASS"),
    .clock_enable_input_b("BYPASS"), .clock_enable_output_b("BYPASS"),
    .power_up_uninitialized("FALSE"),
    .contents(INIT)
  ) _TECHMAP_REPLACE_ (
    .clock0(PORT_A_CLK), .clocken0(1'b1),
    .address_a(PORT_A_ADDR[12:UNUSED]), .data_a({WIDTH{1'b0}}), .wren_a(1'b0),
    .rden_a(PORT_A_RD_EN), .q_a(PORT_A_RD_DATA),
    .address_b(PORT_B_ADDR[12:UNUSED]), .rden_b(PORT_B_RD_EN), .q_b(PORT_B_RD_DATA)
  );
endmodule
