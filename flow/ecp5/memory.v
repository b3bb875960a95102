// Port A of the block writes, port B reads.
module \$__ECP5_NARROW_ (PORT_W_CLK, PORT_W_ADDR, PORT_W_WR_DATA, PORT_W_WR_EN,
                         PORT_R_CLK, PORT_R_ADDR, PORT_R_RD_DATA, PORT_R_RD_EN);
  parameter WIDTH = 9;
  parameter PORT_W_WR_EN_WIDTH = 1;
  input PORT_W_CLK, PORT_R_CLK, PORT_W_WR_EN, PORT_R_RD_EN;
  input [13:0] PORT_W_ADDR, PORT_R_ADDR;
  input [WIDTH-1:0] PORT_W_WR_DATA;
  output [WIDTH-1:0] PORT_R_RD_DATA;
  wire [8:0] data = PORT_W_WR_DATA, q;
  assign PORT_R_RD_DATA = q[WIDTH-1:0];
  DP16KD #(
    .DATA_WIDTH_A(WIDTH), .DATA_WIDTH_B(WIDTH), .CLKAMUX("CLKA"), .CLKBMUX("CLKB"), .GSR("DISABLED")
  ) _TECHMAP_REPLACE_ (
    .CLKA(PORT_W_CLK), .CEA(1'b1), .OCEA(1'b0), .WEA(PORT_W_WR_EN), .RSTA(1'b0),
    .CSA0(1'b0), .CSA1(1'b0), .CSA2(1'b0),
    .ADA0(PORT_W_ADDR[0]), .ADA1(PORT_W_ADDR[1]), .ADA2(PORT_W_ADDR[2]), .ADA3(PORT_W_ADDR[3]),
    .ADA4(PORT_W_ADDR[4]), .ADA5(PORT_W_ADDR[5]), .ADA6(PORT_W_ADDR[6]), .ADA7(PORT_W_ADDR[7]),
    .ADA8(PORT_W_ADDR[8]), .ADA9(PORT_W_ADDR[9]), .ADA10(PORT_W_ADDR[10]), .ADA11(PORT_W_ADDR[11]),
    .ADA12(PORT_W_ADDR[12]), .ADA13(PORT_W_ADDR[13]),
    .DIA0(data[0]), .DIA1(data[1]), .DIA2(data[2]), .DIA3(data[3]), .DIA4(data[4]), .DIA5(data[5]),
    .DIA6(data[6]), .DIA7(data[7]), .DIA8(data[8]),
    .CLKB(PORT_R_CLK), .CEB(PORT_R_RD_EN), .OCEB(1'b1), .WEB(1'b0), .RSTB(1'b0),
    .CSB0(1'b0), .CSB1(1'b0), .CSB2(1'b0),
    .ADB0(PORT_R_ADDR[0]), .ADB1(PORT_R_ADDR[1]), .ADB2(PORT_R_ADDR[2]), .ADB3(PORT_R_ADDR[3]),
    .ADB4(PORT_R_ADDR[4]), .ADB5(PORT_R_ADDR[5]), .ADB6(PORT_R_ADDR[6]), .ADB7(PORT_R_ADDR[7]),
    .ADB8(PORT_R_ADDR[8]), .ADB9(PORT_R_ADDR[9]), .ADB10(PORT_R_ADDR[10]), .ADB11(PORT_R_ADDR[11]),
    .ADB12(PORT_R_ADDR[12]), .ADB13(PORT_R_ADDR[13]),
    .DOB0(q[0]), .DOB1(q[1]), .DOB2(q[2]), .DOB3(q[3]), .DOB4(q[4]), .DOB5(q[5]), .DOB6(q[6]),
    .DOB7(q[7]), .DOB8(q[8])
  );
endmodule
